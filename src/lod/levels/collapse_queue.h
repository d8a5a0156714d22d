// SPDX-License-Identifier: MIT
//
// Edges to be collapsed, cheap ones first, in buckets of about the same cost: adding and taking one
// is a few instructions. In each bucket, first come is first served, which spreads collapses of flat
// parts over their surface.
#pragma once

#include "base/core/context.h"

#include <string.h>

// 64 buckets to an octave, 32 octaves below the highest cost. Lower ones are as good as 0.
enum { STP_COST_SHIFT = 17, STP_COST_BUCKETS = 64 * 32 };

/// An edge to be collapsed. Its cost is out of date if a stamp of its ends has changed.
typedef struct stp_collapse_candidate {
    uint32_t a, b, stamp;
    uint32_t next; ///< of the same bucket; UINT32_MAX: the last
} stp_collapse_candidate;

typedef struct stp_collapse_bucket {
    uint32_t first, last; ///< candidates; first UINT32_MAX: none
} stp_collapse_bucket;

typedef struct stp_collapse_queue {
    stp_context* context;
    stp_collapse_candidate* candidates;
    size_t capacity;
    uint32_t count;                                    ///< candidates, those taken included
    uint32_t cheapest;                                 ///< all buckets before are empty
    uint32_t lowest;                                   ///< of costs in buckets: the first
    stp_collapse_bucket buckets[STP_COST_BUCKETS + 1]; ///< the last: of those that wait
} stp_collapse_queue;

static inline uint32_t stp_collapse_queue_class(float cost)
{
    uint32_t bits; // ascend with the cost
    memcpy(&bits, &cost, sizeof(bits));
    return bits >> STP_COST_SHIFT;
}

/// Begins an empty queue. `highest`: costs above are equal. Free `candidates` in the end.
static inline void stp_collapse_queue_begin(stp_context* context, float highest,
                                            stp_collapse_queue* queue)
{
    uint32_t last = stp_collapse_queue_class(highest);
    queue->context = context;
    queue->candidates = NULL;
    queue->capacity = 0;
    queue->count = 0;
    queue->cheapest = STP_COST_BUCKETS + 1;
    queue->lowest = last > STP_COST_BUCKETS - 1 ? last - (STP_COST_BUCKETS - 1) : 0;
    memset(queue->buckets, 0xff, sizeof(queue->buckets));
}

/// Adds a candidate to a bucket. @return false if memory runs out
static inline bool stp_collapse_queue_put(stp_collapse_queue* queue, stp_collapse_candidate item,
                                          uint32_t index)
{
    if (queue->count >= queue->capacity &&
        !STP_MAKE_ROOM(queue->context, queue->candidates, queue->capacity,
                       (size_t)queue->count + 1)) {
        return false;
    }
    uint32_t number = queue->count++;
    item.next = UINT32_MAX;
    queue->candidates[number] = item;
    stp_collapse_bucket* to = &queue->buckets[index];
    if (to->first == UINT32_MAX) {
        to->first = number;
    } else {
        queue->candidates[to->last].next = number;
    }
    to->last = number;
    queue->cheapest = index < queue->cheapest ? index : queue->cheapest;
    return true;
}

/// Adds a candidate of a cost, 0 or more. @return false if memory runs out
static inline bool stp_collapse_queue_add(stp_collapse_queue* queue, stp_collapse_candidate item,
                                          float cost)
{
    uint32_t class = stp_collapse_queue_class(cost);
    uint32_t index = class > queue->lowest ? class - queue->lowest : 0;
    return stp_collapse_queue_put(queue, item,
                                  index < STP_COST_BUCKETS ? index : STP_COST_BUCKETS - 1);
}

/// Adds a candidate that is taken after all others. @return false if memory runs out
static inline bool stp_collapse_queue_wait(stp_collapse_queue* queue, stp_collapse_candidate item)
{
    return stp_collapse_queue_put(queue, item, STP_COST_BUCKETS);
}

/// Takes the first candidate of the cheapest bucket. `waited`: it is one of those that wait.
/// @return false if there is none
static inline bool stp_collapse_queue_take(stp_collapse_queue* queue, stp_collapse_candidate* item,
                                           bool* waited)
{
    while (queue->cheapest <= STP_COST_BUCKETS &&
           queue->buckets[queue->cheapest].first == UINT32_MAX) {
        queue->cheapest += 1;
    }
    if (queue->cheapest > STP_COST_BUCKETS) {
        return false;
    }
    *waited = queue->cheapest == STP_COST_BUCKETS;
    stp_collapse_bucket* from = &queue->buckets[queue->cheapest];
    *item = queue->candidates[from->first];
    from->first = item->next;
    return true;
}
