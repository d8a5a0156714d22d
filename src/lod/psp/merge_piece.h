// SPDX-License-Identifier: MIT
// One piece of a merge: splats, the links between them, and the queue that merges them. A small
// cloud is one piece; of a large one, several pieces are merged at a time.
#pragma once

#include "lod/psp/queue.h"

/// of a link: it leads to a splat of another piece, by its slot
#define STP_PSP_OUTSIDE 0x80000000u
#define STP_PSP_RECORDED 0x80000000u ///< of an id: it is the number of a record of the same piece

/// A splat that is beside another, and the error of merging the two; infinite where that is not
/// allowed.
typedef struct stp_psp_link {
    uint32_t to;
    float error;
} stp_psp_link;

/// Where the links of a splat lie.
typedef struct stp_psp_span {
    size_t begin;
    uint32_t count, room;
} stp_psp_span;

/// A merge that was made.
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
    uint32_t first; ///< slot of the first splat, of all pieces
    bool history;   ///< merges are recorded
    // arrays for `count` splats
    stp_psp_splat* splats;
    uint8_t* states;
    stp_psp_span* spans;
    stp_psp_best* bests;
    uint32_t* forward; ///< the splat that took it; itself: it lives
    uint32_t* marks;   ///< of splats seen, by `stamp`
    uint32_t* near;    ///< room for `neighbours` a splat
    stp_psp_queue queue;
    stp_psp_link* links;
    stp_psp_record* records;
    uint32_t record_count, stamp;
    size_t link_count, splat_room, link_room, near_room, record_room;
} stp_psp_piece;

/// Begins another piece in the same memory, for so many splats without links. @return false where
/// memory runs out
bool stp_psp_piece_begin(stp_psp_piece* piece, uint32_t count);
/// Makes room for so many links in all, and for the lists of merges. What was there is lost.
/// @return false where memory runs out
bool stp_psp_piece_make_links(stp_psp_piece* piece, size_t count);
void stp_psp_piece_destroy(stp_psp_piece* piece);

/// Merges pairs within the piece, the least error first, until the next one is above `limit` or
/// `least` splats are left. Links have their errors. @return false where memory runs out
bool stp_psp_piece_run(stp_psp_piece* piece, float limit, uint32_t least);

static inline void* stp_psp_state(const stp_psp_piece* piece, uint32_t splat)
{
    return piece->states + piece->metric->state_bytes * splat;
}

static inline float stp_psp_piece_error(const stp_psp_piece* piece, uint32_t a, uint32_t b)
{
    return stp_psp_pair_error(piece->shared, piece->metric, &piece->splats[a],
                              stp_psp_state(piece, a), &piece->splats[b], stp_psp_state(piece, b));
}
