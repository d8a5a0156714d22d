// SPDX-License-Identifier: MIT
//
// Edges to be collapsed: the cheapest first, of equal ones the first offered. A heap with four
// children each, of keys that are single numbers: half as deep as one of pairs, and its comparisons
// need no branches.
#pragma once

#include "base/core/context.h"

#include <assert.h>
#include <string.h>

/// An edge to be collapsed. Its cost is out of date if a stamp of its ends has changed.
typedef struct stp_collapse_candidate {
    uint32_t a, b, stamp;
} stp_collapse_candidate;

/// Free `candidates` and `heap` in the end. All zero but the context: empty.
typedef struct stp_collapse_queue {
    stp_context* context;
    stp_collapse_candidate* candidates;
    uint32_t count; ///< candidates, those taken included
    uint64_t* heap; ///< the bits of a cost above the number of its candidate
    size_t heap_count, capacity, heap_capacity;
} stp_collapse_queue;

enum { STP_COLLAPSE_WAITS = 0x7fffffff }; ///< above the bits of any cost

/// Makes room for so many candidates. @return false if memory runs out
static inline bool stp_collapse_queue_reserve(stp_collapse_queue* queue, size_t count)
{
    return STP_MAKE_ROOM(queue->context, queue->heap, queue->heap_capacity, count) &&
           STP_MAKE_ROOM(queue->context, queue->candidates, queue->capacity, count);
}

/// Adds a candidate. @return false if memory runs out
static inline bool stp_collapse_queue_put(stp_collapse_queue* queue, stp_collapse_candidate item,
                                          uint32_t bits)
{
    if (queue->count >= queue->capacity &&
        !stp_collapse_queue_reserve(queue, (size_t)queue->count + 1)) {
        return false;
    }
    assert(queue->heap_count < queue->heap_capacity && "there is room for all candidates");
    uint32_t number = queue->count++;
    uint64_t key = (uint64_t)bits << 32 | number, *heap = queue->heap;
    size_t at = queue->heap_count++;
    queue->candidates[number] = item;
    for (; at > 0 && key < heap[(at - 1) / 4]; at = (at - 1) / 4) {
        heap[at] = heap[(at - 1) / 4];
    }
    heap[at] = key;
    return true;
}

/// Adds a candidate of a finite cost, 0 or more. @return false if memory runs out
static inline bool stp_collapse_queue_add(stp_collapse_queue* queue, stp_collapse_candidate item,
                                          float cost)
{
    uint32_t bits; // ascend with the cost
    memcpy(&bits, &cost, sizeof(bits));
    assert(bits < STP_COLLAPSE_WAITS);
    return stp_collapse_queue_put(queue, item, bits);
}

/// Adds a candidate that is taken after all others. @return false if memory runs out
static inline bool stp_collapse_queue_wait(stp_collapse_queue* queue, stp_collapse_candidate item)
{
    return stp_collapse_queue_put(queue, item, STP_COLLAPSE_WAITS);
}

/// Index of the smallest of the up to four keys that start at `first`. There must be at least one.
static inline size_t stp_collapse_queue_least(const stp_collapse_queue* queue, size_t first)
{
    const uint64_t* h = queue->heap + first;
    if (queue->heap_count - first >= 4) {
        size_t a = h[1] < h[0], b = 2 + (size_t)(h[3] < h[2]);
        return first + (h[b] < h[a] ? b : a);
    }
    size_t least = 0;
    for (size_t i = 1; i < queue->heap_count - first; ++i) {
        least = h[i] < h[least] ? i : least;
    }
    return first + least;
}

/// Takes the cheapest candidate. `waited`: it is one of those that wait. @return false if there is
/// none
static inline bool stp_collapse_queue_take(stp_collapse_queue* queue, stp_collapse_candidate* item,
                                           bool* waited)
{
    if (queue->heap_count == 0) {
        return false;
    }
    uint64_t top = queue->heap[0], key = queue->heap[--queue->heap_count];
    size_t at = 0;
    for (size_t child = 1; child < queue->heap_count; child = 4 * at + 1) {
        size_t least = stp_collapse_queue_least(queue, child);
        if (key < queue->heap[least]) {
            break;
        }
        queue->heap[at] = queue->heap[least];
        at = least;
    }
    queue->heap[at] = key;
    *item = queue->candidates[(uint32_t)top];
    *waited = top >> 32 == STP_COLLAPSE_WAITS;
    return true;
}
