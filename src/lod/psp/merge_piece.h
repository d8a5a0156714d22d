// SPDX-License-Identifier: MIT
// One piece of a merge: splats, the links between them, and the queue that merges them. A small
// cloud is one piece; a large one is split into pieces that are merged in parallel.
#pragma once

#include "lod/psp/metric.h"

#include <assert.h>

// A priority queue of splats by the error of their best merge: a heap with four children per node
// that tracks the position of each splat.

typedef struct stp_psp_queue_entry {
    float error;
    uint32_t splat;
} stp_psp_queue_entry;

/// On ties, the splat with the lower key comes first.
typedef struct stp_psp_queue {
    stp_psp_queue_entry* heap; ///< capacity for all splats
    uint32_t* places;          ///< position of each splat in the heap; UINT32_MAX: not queued
    const stp_psp_splat* splats;
    uint32_t count;
} stp_psp_queue;

/// Appends an entry of a splat that is not queued. Call stp_psp_queue_order after the last one.
void stp_psp_queue_append(stp_psp_queue* queue, uint32_t splat, float error);
void stp_psp_queue_order(stp_psp_queue* queue);

/// Queues a splat, or moves it to another error.
void stp_psp_queue_set(stp_psp_queue* queue, uint32_t splat, float error);
/// Removes a splat; does nothing if it is not queued.
void stp_psp_queue_remove(stp_psp_queue* queue, uint32_t splat);

/// Flag of a link: it refers to a slot, a splat of another piece.
#define STP_PSP_OUTSIDE 0x80000000u
#define STP_PSP_RECORDED 0x80000000u ///< flag of an id: a record number in the same piece

/// Link to a neighbouring splat, and the error of merging the two; infinite if not allowed.
typedef struct stp_psp_link {
    uint32_t to;
    float error;
} stp_psp_link;

/// Location of a splat's links in the list.
typedef struct stp_psp_span {
    size_t begin;
    uint32_t count, room;
} stp_psp_span;

/// A completed merge.
typedef struct stp_psp_record {
    uint32_t left, right; ///< ids
    float error;
    stp_ellipse ellipse;
    uint8_t color[3];
} stp_psp_record;

typedef struct stp_psp_best {
    float error;
    uint32_t partner;
} stp_psp_best;

typedef struct stp_psp_piece {
    const stp_psp_shared* shared;
    const stp_psp_metric_table* metric;
    uint32_t count, live;
    uint32_t first; ///< slot of the first splat, counted over all pieces
    bool history;   ///< record merges
    // arrays for `count` splats, and one spare
    stp_psp_splat* splats;
    uint8_t* states;
    stp_psp_span* spans;
    stp_psp_best* bests;
    uint32_t* forward; ///< the splat that consumed it; itself: still alive
    uint32_t* marks;   ///< `stamp` for splats already visited
    uint32_t* near;    ///< space for `neighbours` entries per splat
    stp_psp_queue queue;
    stp_psp_link* links;
    stp_psp_record* records;
    uint32_t record_count, stamp;
    size_t link_count, splat_room, link_room, near_room, record_room;
} stp_psp_piece;

/// Starts a new piece in the same memory, for this many splats without links.
/// @return false if out of memory
bool stp_psp_piece_begin(stp_psp_piece* piece, uint32_t count);
/// Makes space for lists of this many links in total, and for lists joined by merges. Discards
/// previous content.
/// @return false if out of memory
bool stp_psp_piece_make_links(stp_psp_piece* piece, size_t count);
void stp_psp_piece_destroy(stp_psp_piece* piece);

/// Merges pairs within the piece, least error first, until the next error is above `limit` or
/// `minimum` splats are left. Links must have their errors. @return false if out of memory
bool stp_psp_piece_run(stp_psp_piece* piece, float limit, uint32_t minimum);

static inline void* stp_psp_state(const stp_psp_piece* piece, uint32_t splat)
{
    assert(splat <= piece->count && "a splat, or the spare one");
    return piece->states + piece->metric->state_bytes * splat;
}

static inline float stp_psp_piece_error(const stp_psp_piece* piece, uint32_t a, uint32_t b)
{
    return stp_psp_pair_error(piece->shared, piece->metric, &piece->splats[a],
                              stp_psp_state(piece, a), &piece->splats[b], stp_psp_state(piece, b));
}
