// SPDX-License-Identifier: MIT
#include "lod/psp/merge_piece.h"

#include <assert.h>

enum { CHILDREN = 4 };

static inline bool is_before(const stp_psp_queue* q, stp_psp_queue_entry a, stp_psp_queue_entry b)
{
    return a.error < b.error ||
           (a.error == b.error && q->splats[a.splat].key < q->splats[b.splat].key);
}

static inline void put(stp_psp_queue* q, uint32_t place, stp_psp_queue_entry entry)
{
    assert(place < q->count);
    q->heap[place] = entry;
    q->places[entry.splat] = place;
}

static void move_up(stp_psp_queue* q, uint32_t place, stp_psp_queue_entry entry)
{
    while (place > 0 && is_before(q, entry, q->heap[(place - 1) / CHILDREN])) {
        put(q, place, q->heap[(place - 1) / CHILDREN]);
        place = (place - 1) / CHILDREN;
    }
    put(q, place, entry);
}

static void move_down(stp_psp_queue* q, uint32_t place, stp_psp_queue_entry entry)
{
    for (uint32_t first = CHILDREN * place + 1; first < q->count; first = CHILDREN * place + 1) {
        uint32_t end = first + CHILDREN < q->count ? first + CHILDREN : q->count, minimum = first;
        for (uint32_t child = first + 1; child < end; ++child) {
            minimum = is_before(q, q->heap[child], q->heap[minimum]) ? child : minimum;
        }
        if (!is_before(q, q->heap[minimum], entry)) {
            break;
        }
        put(q, place, q->heap[minimum]);
        place = minimum;
    }
    put(q, place, entry);
}

void stp_psp_queue_append(stp_psp_queue* q, uint32_t splat, float error)
{
    assert(q->places[splat] == UINT32_MAX && "not queued yet");
    put(q, q->count++, (stp_psp_queue_entry){error, splat});
}

void stp_psp_queue_order(stp_psp_queue* q)
{
    for (uint32_t place = q->count / CHILDREN + 1; place-- > 0;) {
        if (place < q->count) {
            move_down(q, place, q->heap[place]);
        }
    }
}

void stp_psp_queue_set(stp_psp_queue* q, uint32_t splat, float error)
{
    uint32_t place = q->places[splat];
    assert(place == UINT32_MAX || (place < q->count && q->heap[place].splat == splat));
    stp_psp_queue_entry entry = {error, splat};
    if (place == UINT32_MAX) {
        move_up(q, q->count++, entry);
    } else if (error < q->heap[place].error) {
        move_up(q, place, entry);
    } else {
        move_down(q, place, entry);
    }
}

void stp_psp_queue_remove(stp_psp_queue* q, uint32_t splat)
{
    uint32_t place = q->places[splat];
    if (place == UINT32_MAX) {
        return;
    }
    assert(place < q->count && q->heap[place].splat == splat);
    q->places[splat] = UINT32_MAX;
    stp_psp_queue_entry last = q->heap[--q->count];
    if (last.splat != splat) {
        if (place > 0 && is_before(q, last, q->heap[(place - 1) / CHILDREN])) {
            move_up(q, place, last);
        } else {
            move_down(q, place, last);
        }
    }
}
