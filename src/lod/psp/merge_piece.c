// SPDX-License-Identifier: MIT
#include "lod/psp/merge_piece.h"

#include "base/math/color.h"

#include <assert.h>
#include <string.h>

static const stp_psp_best no_best = {HUGE_VALF, UINT32_MAX};

/// Reallocates an array without keeping its content.
static bool reallocate(stp_context* context, void* array, size_t count, size_t size)
{
    void** at = array;
    stp_free(context, *at);
    *at = stp_alloc_array(context, count, size);
    return *at != NULL;
}

bool stp_psp_piece_begin(stp_psp_piece* p, uint32_t count)
{
    assert(count < STP_PSP_OUTSIDE && "the flag of a link");
    assert(p->metric->state_bytes % 8 == 0 && p->metric->state_bytes <= STP_PSP_STATE_MAX);
    stp_context* context = p->shared->context;
    size_t room = (size_t)count + 1;
    if (p->splat_room < room) {
        p->splat_room = 0;
        // one extra for the result of the next merge
        if (!reallocate(context, &p->splats, room, sizeof(*p->splats)) ||
            !reallocate(context, &p->states, room, p->metric->state_bytes + 1) ||
            !reallocate(context, &p->spans, room, sizeof(*p->spans)) ||
            !reallocate(context, &p->bests, room, sizeof(*p->bests)) ||
            !reallocate(context, &p->forward, room, sizeof(*p->forward)) ||
            !reallocate(context, &p->marks, room, sizeof(*p->marks)) ||
            !reallocate(context, &p->queue.heap, room, sizeof(*p->queue.heap)) ||
            !reallocate(context, &p->queue.places, room, sizeof(*p->queue.places))) {
            return false;
        }
        p->splat_room = room;
    }
    p->queue.splats = p->splats;
    p->queue.count = 0;
    p->count = p->live = count;
    p->record_count = p->stamp = 0;
    p->link_count = 0;
    memset(p->marks, 0, count * sizeof(*p->marks));
    memset(p->queue.places, 0xff, count * sizeof(*p->queue.places));
    for (uint32_t i = 0; i < count; ++i) {
        p->forward[i] = i;
    }
    return true;
}

bool stp_psp_piece_make_links(stp_psp_piece* p, size_t count)
{
    // twice the count: any new list fits after all lists in use
    size_t room = 2 * count + 1;
    if (p->link_room < room) {
        p->link_room = 0;
        if (!reallocate(p->shared->context, &p->links, room, sizeof(*p->links))) {
            return false;
        }
        p->link_room = room;
    }
    return true;
}

void stp_psp_piece_destroy(stp_psp_piece* p)
{
    stp_context* context = p->shared->context;
    stp_free(context, p->splats);
    stp_free(context, p->states);
    stp_free(context, p->spans);
    stp_free(context, p->bests);
    stp_free(context, p->forward);
    stp_free(context, p->marks);
    stp_free(context, p->near);
    stp_free(context, p->queue.heap);
    stp_free(context, p->queue.places);
    stp_free(context, p->links);
    stp_free(context, p->records);
    *p = (stp_psp_piece){.shared = p->shared, .metric = p->metric, .history = p->history};
}

/// Whether a merge is better than a splat's best one so far.
static inline bool is_better(const stp_psp_piece* p, float error, uint32_t to, stp_psp_best best)
{
    return error < best.error || (error == best.error && best.partner != UINT32_MAX &&
                                  p->splats[to].key < p->splats[best.partner].key);
}

static stp_psp_best find_best(const stp_psp_piece* p, uint32_t splat)
{
    const stp_psp_link* links = p->links + p->spans[splat].begin;
    stp_psp_best best = no_best;
    for (uint32_t i = 0; i < p->spans[splat].count; ++i) {
        if (is_better(p, links[i].error, links[i].to, best)) {
            best = (stp_psp_best){links[i].error, links[i].to};
        }
    }
    return best;
}

/// Compacts the lists in use. @return false if out of memory
static bool tidy_links(stp_psp_piece* p)
{
    stp_psp_link* moved = STP_NEW_ARRAY(p->shared->context, stp_psp_link, p->link_room);
    if (moved == NULL) {
        return false;
    }
    p->link_count = 0;
    for (uint32_t i = 0; i < p->count; ++i) {
        stp_psp_span* s = &p->spans[i];
        if (p->forward[i] == i) {
            memcpy(moved + p->link_count, p->links + s->begin, s->count * sizeof(*moved));
            s->begin = p->link_count;
            s->room = s->count;
            p->link_count += s->count;
        }
    }
    assert(p->link_count <= p->link_room / 2 && "merges never add links");
    stp_free(p->shared->context, p->links);
    p->links = moved;
    return true;
}

/// Gives splat a the links of both, without those between them.
static bool join_links(stp_psp_piece* p, uint32_t a, uint32_t b)
{
    size_t maximum = (size_t)p->spans[a].count + p->spans[b].count;
    if (p->link_room - p->link_count < maximum && !tidy_links(p)) {
        return false;
    }
    assert(p->link_room - p->link_count >= maximum);
    stp_psp_link* joined = p->links + p->link_count;
    uint32_t kept = 0, parts[2] = {a, b};
    p->stamp += 1;
    for (int part = 0; part < 2; ++part) {
        const stp_psp_link* links = p->links + p->spans[parts[part]].begin;
        for (uint32_t i = 0; i < p->spans[parts[part]].count; ++i) {
            uint32_t to = links[i].to;
            if (to == a || to == b) {
                continue;
            }
            if ((to & STP_PSP_OUTSIDE) == 0) {
                if (p->marks[to] == p->stamp) {
                    continue;
                }
                p->marks[to] = p->stamp;
            }
            joined[kept++] = links[i];
        }
    }
    stp_psp_span* s = &p->spans[a];
    if (kept <= s->room) {
        memcpy(p->links + s->begin, joined, kept * sizeof(*joined));
    } else {
        s->begin = p->link_count;
        s->room = kept;
        p->link_count += kept;
    }
    s->count = kept;
    return true;
}

/// Queues a splat by its best merge. A lazy queue only moves splats forwards; moves backwards are
/// delayed until the splat reaches the front.
static void requeue(stp_psp_piece* p, uint32_t splat, float limit)
{
    float error = p->bests[splat].error;
    assert(error >= 0.0f && p->forward[splat] == splat);
    uint32_t place = p->queue.places[splat];
    if (!p->shared->desc.eager && place != UINT32_MAX && error >= p->queue.heap[place].error) {
        return;
    }
    if (error <= limit && error < HUGE_VALF) {
        stp_psp_queue_set(&p->queue, splat, error);
    } else {
        stp_psp_queue_remove(&p->queue, splat);
    }
}

/// Replaces a splat's links to a and b by one link to a.
static void relink(stp_psp_piece* p, uint32_t splat, uint32_t a, uint32_t b, float error,
                   float limit)
{
    stp_psp_span* s = &p->spans[splat];
    stp_psp_link* links = p->links + s->begin;
    uint32_t at_a = UINT32_MAX, at_b = UINT32_MAX;
    for (uint32_t i = 0; i < s->count; ++i) {
        at_a = links[i].to == a ? i : at_a;
        at_b = links[i].to == b ? i : at_b;
    }
    assert(at_a != UINT32_MAX || at_b != UINT32_MAX); // links are bidirectional
    links[at_a != UINT32_MAX ? at_a : at_b] = (stp_psp_link){a, error};
    if (at_a != UINT32_MAX && at_b != UINT32_MAX) {
        links[at_b] = links[--s->count];
    }
    stp_psp_best* best = &p->bests[splat];
    if (best->partner == a || best->partner == b) {
        *best = find_best(p, splat);
        requeue(p, splat, limit);
    } else if (is_better(p, error, a, *best)) {
        *best = (stp_psp_best){error, a};
        requeue(p, splat, limit);
    }
}

static bool record(stp_psp_piece* p, uint32_t a, uint32_t b, const stp_psp_splat* merged)
{
    assert(p->record_count == p->count - p->live && "one record per earlier merge");
    if (p->record_count == p->record_room) {
        if (!STP_MAKE_ROOM(p->shared->context, p->records, p->record_room,
                           (size_t)p->record_count + 1)) {
            return false;
        }
    }
    stp_psp_record* r = &p->records[p->record_count++];
    *r = (stp_psp_record){.left = p->splats[a].id,
                          .right = p->splats[b].id,
                          .error = p->bests[a].error,
                          .ellipse = merged->ellipse};
    for (int k = 0; k < 3; ++k) {
        r->color[k] = stp_linear_to_srgb8(merged->color[k]);
    }
    return true;
}

/// Merges two splats. The one with the lower key becomes the result, so a splat's key never
/// changes.
static bool merge(stp_psp_piece* p, uint32_t a, uint32_t b, float limit)
{
    if (p->splats[b].key < p->splats[a].key) {
        uint32_t swap = a;
        a = b;
        b = swap;
    }
    assert(a < p->count && b < p->count && a != b && "a merge within the piece");
    assert(p->forward[a] == a && p->forward[b] == b && "neither was consumed");
    stp_psp_splat* merged = &p->splats[p->count];
    void* state = stp_psp_state(p, p->count);
    stp_psp_merge_pair(p->shared, p->metric, &p->splats[a], stp_psp_state(p, a), &p->splats[b],
                       stp_psp_state(p, b), merged, state);
    assert(merged->key == p->splats[a].key);
    if (p->history) {
        merged->id = STP_PSP_RECORDED | p->record_count;
        if (!record(p, a, b, merged)) {
            return false;
        }
    }
    p->splats[a] = *merged;
    memcpy(stp_psp_state(p, a), state, p->metric->state_bytes);
    if (p->shared->desc.eager) {
        stp_psp_queue_remove(&p->queue, b);
    }
    if (!join_links(p, a, b)) {
        return false;
    }
    p->forward[b] = a; // only now: its links were still in use
    p->live -= 1;
    stp_psp_link* links = p->links + p->spans[a].begin;
    p->bests[a] = no_best;
    for (uint32_t i = 0; i < p->spans[a].count; ++i) {
        uint32_t to = links[i].to;
        if ((to & STP_PSP_OUTSIDE) == 0) {
            links[i].error = stp_psp_piece_error(p, a, to);
            relink(p, to, a, b, links[i].error, limit);
            if (is_better(p, links[i].error, to, p->bests[a])) {
                p->bests[a] = (stp_psp_best){links[i].error, to};
            }
        }
    }
    requeue(p, a, limit);
    return true;
}

bool stp_psp_piece_run(stp_psp_piece* p, float limit, uint32_t minimum)
{
    assert(limit >= 0.0f);
    assert(p->live == p->count && p->queue.count == 0 && "a piece runs once");
    for (uint32_t i = 0; i < p->count; ++i) {
        p->bests[i] = find_best(p, i);
        if (p->bests[i].error <= limit && p->bests[i].error < HUGE_VALF) {
            stp_psp_queue_append(&p->queue, i, p->bests[i].error);
        }
    }
    stp_psp_queue_order(&p->queue);
    while (p->live > minimum && p->queue.count > 0) {
        stp_psp_queue_entry first = p->queue.heap[0];
        stp_psp_best best = p->bests[first.splat];
        if (p->forward[first.splat] != first.splat) {
            stp_psp_queue_remove(&p->queue, first.splat);
        } else if (best.error != first.error) { // it was queued with an outdated error
            if (best.error <= limit && best.error < HUGE_VALF) {
                stp_psp_queue_set(&p->queue, first.splat, best.error);
            } else {
                stp_psp_queue_remove(&p->queue, first.splat);
            }
        } else if (!merge(p, first.splat, best.partner, limit)) {
            return false;
        }
    }
    assert((p->live >= minimum || p->live == p->count) && p->live <= p->count);
    return true;
}
