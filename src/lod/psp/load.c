// SPDX-License-Identifier: MIT
#include "base/math/color.h"
#include "lod/psp/initial.h"
#include "lod/psp/rounds.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

enum { SORTED_BY_INSERTION = 16 };

static uint32_t neighbours_of(const stp_psp_rounds* r)
{
    assert(r->tree.count > 0 && "the tree exists in the first round only");
    uint32_t others = r->tree.count - 1, k = r->shared.desc.neighbours;
    return k < others ? k : others;
}

/// Makes the initial splat of the point at a place of the tree.
static void begin_splat(const stp_psp_rounds* r, uint32_t place, const uint32_t* near,
                        uint32_t count, stp_psp_splat* splat, void* state)
{
    const stp_psp_points* points = r->shared.points;
    uint32_t point = stp_kd_index(&r->tree, place);
    uint32_t at = r->in_tree_order ? place : point;
    const float* n = points->normals != NULL ? points->normals + 3 * (size_t)at : NULL;
    stp_vec3 given = n != NULL ? (stp_vec3){n[0], n[1], n[2]} : (stp_vec3){0};
    splat->ellipse = stp_psp_initial_splat(&r->tree, place, near, count,
                                           stp_is_finite(given) ? given : (stp_vec3){0}, r->alone);
    splat->area = stp_ellipse_area(&splat->ellipse);
    for (size_t k = 0; k < 3; ++k) {
        uint8_t color = points->colors != NULL ? stp_psp_color(points, at)[k] : 255;
        splat->color[k] = stp_srgb8_to_linear(color);
    }
    splat->id = splat->key = point;
    if (r->metric->begin != NULL) {
        r->metric->begin(&r->shared, at, splat, state);
    }
}

static void add_link(stp_psp_piece* p, uint32_t from, uint32_t to, float error)
{
    stp_psp_span* s = &p->spans[from];
    assert(s->count < s->room && s->begin + s->room <= p->link_count);
    p->links[s->begin + s->count++] = (stp_psp_link){to, error};
}

static bool lists(const uint32_t* near, uint32_t count, uint32_t place)
{
    for (uint32_t n = 0; n < count; ++n) {
        if (near[n] == place) {
            return true;
        }
    }
    return false;
}

/// Links two splats if the point of either is among the nearest neighbours of the other.
static bool link_points(stp_psp_piece* p, uint32_t begin, uint32_t k)
{
    size_t total = 0;
    for (uint32_t i = 0; i < p->count; ++i) {
        p->spans[i] = (stp_psp_span){.room = k};
    }
    for (size_t i = 0; i < (size_t)p->count * k; ++i) {
        if (p->near[i] - begin < p->count) {
            p->spans[p->near[i] - begin].room += 1;
        }
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        p->spans[i].begin = total;
        total += p->spans[i].room;
    }
    if (!stp_psp_piece_make_links(p, total)) {
        return false;
    }
    p->link_count = total;
    for (uint32_t i = 0; i < p->count; ++i) {
        const uint32_t* near = p->near + (size_t)i * k;
        for (uint32_t n = 0; n < k; ++n) {
            uint32_t to = near[n] - begin;
            if (to >= p->count) {
                add_link(p, i, near[n] | STP_PSP_OUTSIDE, HUGE_VALF);
            } else if (to > i || !lists(p->near + (size_t)to * k, k, begin + i)) {
                float error = stp_psp_piece_error(p, i, to);
                add_link(p, i, to, error);
                add_link(p, to, i, error);
            }
        }
    }
    return true;
}

static bool load_points(const stp_psp_rounds* r, stp_psp_piece* p, uint32_t begin)
{
    uint32_t k = neighbours_of(r);
    stp_kd_path path = {.leaf = UINT32_MAX};
    size_t maximum = (size_t)p->count * k + 1;
    if (p->near_room < maximum) {
        p->near_room = 0;
        stp_free(r->shared.context, p->near);
        p->near = STP_NEW_ARRAY(r->shared.context, uint32_t, maximum);
        if (p->near == NULL) {
            return false;
        }
        p->near_room = maximum;
    }
    for (uint32_t i = 0; i < p->count; ++i) {
        uint32_t* near = p->near + (size_t)i * k;
        if (k > 0) {
            uint32_t listed = stp_kd_nearest(&r->tree, &path, begin + i, k, near);
            assert(listed == k && "there are at least k other points");
            (void)listed;
        }
        begin_splat(r, begin + i, near, k, &p->splats[i], stp_psp_state(p, i));
        if (r->initial != NULL) {
            r->initial[p->splats[i].id] = p->splats[i].ellipse;
        }
    }
    return link_points(p, begin, k);
}

/// Location of a splat in a block.
typedef struct found {
    const stp_psp_block* block;
    uint32_t at;
} found;

static uint32_t number_of(const stp_psp_rounds* r, uint32_t slot)
{
    return r->order != NULL ? r->order[slot].index : slot;
}

/// @param hint the last visited block
static found find_splat(const stp_psp_rounds* r, uint32_t slot, uint32_t* hint)
{
    uint32_t number = number_of(r, slot);
    const stp_psp_block* b = &r->blocks[*hint];
    if (number - b->first >= b->count) {
        uint32_t low = 0, high = r->block_count;
        while (high - low > 1) {
            uint32_t middle = low + (high - low) / 2;
            *(r->blocks[middle].first <= number ? &low : &high) = middle;
        }
        *hint = low;
        b = &r->blocks[low];
    }
    assert(number - b->first < b->count && "blocks hold all numbers");
    return (found){b, number - b->first};
}

/// First reverse link of a slot.
static size_t find_reverse(const stp_psp_rounds* r, uint32_t slot)
{
    size_t low = 0, high = r->reverse_count;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (r->reverse[middle] >> 32 < slot) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    assert(low == r->reverse_count || r->reverse[low] >> 32 >= slot);
    return low;
}

/// Links splat i with the one in a slot, unless they are already linked.
static void link_slot(stp_psp_piece* p, uint32_t i, uint32_t slot)
{
    uint32_t to = slot - p->first;
    if (to >= p->count) {
        add_link(p, i, slot | STP_PSP_OUTSIDE, HUGE_VALF);
    } else if (to != i && p->marks[to] != i + 1) {
        p->marks[to] = i + 1;
        add_link(p, i, to, HUGE_VALF);
    }
}

static int compare_links(const void* a, const void* b)
{
    uint32_t x = ((const stp_psp_link*)a)->to, y = ((const stp_psp_link*)b)->to;
    return x < y ? -1 : x > y ? 1 : 0;
}

/// Sorts the links of a splat, those to other pieces last, and drops duplicates.
static void tidy_list(stp_psp_piece* p, uint32_t splat)
{
    stp_psp_span* s = &p->spans[splat];
    stp_psp_link* links = p->links + s->begin;
    if (s->count > SORTED_BY_INSERTION) {
        qsort(links, s->count, sizeof(*links), compare_links);
    } else {
        for (uint32_t i = 1; i < s->count; ++i) {
            stp_psp_link link = links[i];
            uint32_t at = i;
            for (; at > 0 && links[at - 1].to > link.to; --at) {
                links[at] = links[at - 1];
            }
            links[at] = link;
        }
    }
    uint32_t kept = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        if (kept == 0 || links[kept - 1].to != links[i].to) {
            links[kept++] = links[i];
        }
    }
    s->count = kept;
}

static void measure_links(stp_psp_piece* p)
{
    for (uint32_t i = 0; i < p->count; ++i) {
        for (uint32_t n = 0; n < p->spans[i].count; ++n) {
            stp_psp_link* link = &p->links[p->spans[i].begin + n];
            if (link->to <= i || (link->to & STP_PSP_OUTSIDE) != 0) {
                continue;
            }
            link->error = stp_psp_piece_error(p, i, link->to);
            stp_psp_link* back = p->links + p->spans[link->to].begin;
            for (uint32_t m = 0; m < p->spans[link->to].count; ++m) {
                if (back[m].to == i) {
                    back[m].error = link->error;
                    break;
                }
            }
        }
    }
}

static bool load_blocks(const stp_psp_rounds* r, stp_psp_piece* p, uint32_t begin)
{
    uint32_t hint = 0;
    size_t total = 0, reverse = find_reverse(r, begin);
    for (uint32_t i = 0; i < p->count; ++i) {
        found f = find_splat(r, begin + i, &hint);
        p->splats[i] = f.block->splats[f.at];
        memcpy(stp_psp_state(p, i), f.block->states + r->metric->state_bytes * f.at,
               r->metric->state_bytes);
        p->spans[i] = (stp_psp_span){.begin = total};
        total += f.block->begins[f.at + 1] - f.block->begins[f.at];
        for (; reverse < r->reverse_count && r->reverse[reverse] >> 32 == begin + i; ++reverse) {
            total += 1;
        }
        p->spans[i].room = (uint32_t)(total - p->spans[i].begin);
    }
    if (!stp_psp_piece_make_links(p, total)) {
        return false;
    }
    p->link_count = total;
    reverse = find_reverse(r, begin);
    for (uint32_t i = 0; i < p->count; ++i) {
        found f = find_splat(r, begin + i, &hint);
        for (uint32_t n = f.block->begins[f.at]; n < f.block->begins[f.at + 1]; ++n) {
            assert((f.block->links[n] & ~STP_PSP_OUTSIDE) < r->slot_count);
            link_slot(p, i, r->survivors[f.block->links[n] & ~STP_PSP_OUTSIDE]);
        }
        for (; reverse < r->reverse_count && r->reverse[reverse] >> 32 == begin + i; ++reverse) {
            link_slot(p, i, (uint32_t)r->reverse[reverse]);
        }
        tidy_list(p, i);
    }
    p->stamp = p->count;
    measure_links(p);
    return true;
}

bool stp_psp_load(const stp_psp_rounds* r, stp_psp_piece* p, uint32_t begin, uint32_t end)
{
    assert(begin < end && end <= r->live);
    assert((r->round == 0) == (r->tree.count > 0) && "points in the first round, then blocks");
    if (!stp_psp_piece_begin(p, end - begin)) {
        return false;
    }
    p->first = begin;
    return r->round == 0 ? load_points(r, p, begin) : load_blocks(r, p, begin);
}

bool stp_psp_unload(stp_psp_piece* p, const stp_psp_room* room, stp_psp_block* b,
                    uint32_t* survivors)
{
    uint32_t count = 0;
    size_t links = 0, state = p->metric->state_bytes;
    for (uint32_t i = 0; i < p->count; ++i) {
        if (p->forward[i] == i) {
            survivors[i] = count++;
            links += p->spans[i].count;
        }
    }
    assert(count == p->live && "splats that were not consumed");
    size_t splat_bytes = count * sizeof(stp_psp_splat), state_bytes = count * state;
    b->memory = stp_psp_room_alloc(
        room, 1, splat_bytes + state_bytes + (count + 1 + links) * sizeof(uint32_t));
    if (b->memory == NULL) {
        return false;
    }
    b->splats = b->memory;
    b->states = (uint8_t*)b->memory + splat_bytes;
    b->begins = (uint32_t*)(void*)(b->states + state_bytes);
    b->links = b->begins + count + 1;
    b->count = count;
    b->begins[0] = 0;
    for (uint32_t i = 0; i < p->count; ++i) {
        uint32_t root = i;
        while (p->forward[root] != root) {
            root = p->forward[root];
        }
        for (uint32_t at = i; at != root;) { // path compression: later lookups are direct
            uint32_t next = p->forward[at];
            p->forward[at] = root;
            at = next;
        }
        survivors[i] = survivors[root];
        if (root != i) {
            continue;
        }
        uint32_t to = survivors[i], end = b->begins[to];
        b->splats[to] = p->splats[i];
        memcpy(b->states + state * to, stp_psp_state(p, i), state);
        for (uint32_t n = 0; n < p->spans[i].count; ++n) {
            uint32_t link = p->links[p->spans[i].begin + n].to;
            b->links[end++] = (link & STP_PSP_OUTSIDE) != 0 ? link : p->first + link;
        }
        b->begins[to + 1] = end;
    }
    assert(b->begins[count] == links && "all links were copied");
    return true;
}

static float best_of_point(const stp_psp_rounds* r, uint32_t place, void* states[2])
{
    uint32_t near[STP_NEIGHBOURS_MAX], others[STP_NEIGHBOURS_MAX], k = neighbours_of(r);
    stp_psp_splat own, other;
    stp_kd_path path = {.leaf = UINT32_MAX};
    float best = HUGE_VALF;
    (void)stp_kd_nearest(&r->tree, &path, place, k, near);
    begin_splat(r, place, near, k, &own, states[0]);
    for (uint32_t n = 0; n < k; ++n) {
        (void)stp_kd_nearest(&r->tree, &path, near[n], k, others);
        begin_splat(r, near[n], others, k, &other, states[1]);
        best = stp_min(
            best, stp_psp_pair_error(&r->shared, r->metric, &own, states[0], &other, states[1]));
    }
    return best;
}

static float best_of_splat(const stp_psp_rounds* r, uint32_t slot)
{
    uint32_t hint = 0;
    size_t state = r->metric->state_bytes;
    found own = find_splat(r, slot, &hint);
    float best = HUGE_VALF;
    for (uint32_t n = own.block->begins[own.at]; n < own.block->begins[own.at + 1]; ++n) {
        assert((own.block->links[n] & ~STP_PSP_OUTSIDE) < r->slot_count);
        uint32_t to = r->survivors[own.block->links[n] & ~STP_PSP_OUTSIDE];
        if (to == slot) {
            continue;
        }
        found other = find_splat(r, to, &hint);
        best = stp_min(best, stp_psp_pair_error(&r->shared, r->metric, &own.block->splats[own.at],
                                                own.block->states + state * own.at,
                                                &other.block->splats[other.at],
                                                other.block->states + state * other.at));
    }
    return best;
}

static int compare_floats(const void* a, const void* b)
{
    float x = *(const float*)a, y = *(const float*)b;
    return x < y ? -1 : x > y ? 1 : 0;
}

uint32_t stp_psp_sample_errors(const stp_psp_rounds* r, float* errors, uint32_t maximum)
{
    uint32_t samples = maximum < r->live ? maximum : r->live, count = 0;
    double states[2][STP_PSP_STATE_MAX / sizeof(double)];
    void* places[2] = {states[0], states[1]};
    for (uint32_t s = 0; s < samples; ++s) {
        uint32_t slot = (uint32_t)((uint64_t)s * r->live / samples);
        assert(slot < r->live);
        stp_psp_rounds_release(r, s);
        float error = r->round == 0 ? best_of_point(r, slot, places) : best_of_splat(r, slot);
        if (error < HUGE_VALF) {
            errors[count++] = error;
        }
    }
    qsort(errors, count, sizeof(*errors), compare_floats);
    return count;
}
