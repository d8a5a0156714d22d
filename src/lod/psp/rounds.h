// SPDX-License-Identifier: MIT
// Merges a large cloud in rounds. Each round splits space into pieces and merges the splats of every
// piece up to one common error. Pairs across a seam wait for the next round, which has other seams.
#pragma once

#include "lod/psp/forest.h"
#include "lod/psp/kd_tree.h"
#include "lod/psp/merge_piece.h"

/// Result of a piece: the surviving splats, and their links.
typedef struct stp_psp_block {
    void* memory; ///< holds all arrays
    stp_psp_splat* splats;
    uint8_t* states;
    uint32_t* begins; ///< index of each splat's first link, count + 1
    uint32_t* links;  ///< slots of the round that made the block; STP_PSP_OUTSIDE: of another piece
    uint32_t count;
    uint32_t first; ///< number of the first splat, counted over all blocks
} stp_psp_block;

/// Merges of a piece, in order.
typedef struct stp_psp_history {
    stp_psp_record* records;
    uint32_t count, first; ///< number of the first merge, counted over all histories
} stp_psp_history;

/// Arrays that grow with the number of points, by their lifetimes.
typedef enum stp_psp_room_use {
    STP_PSP_ROOM_POINTS, ///< points in tree order, and data of the metric
    STP_PSP_ROOM_TREE,
    STP_PSP_ROOM_LEFT, ///< blocks and survivors of the previous round
    STP_PSP_ROOM_NEXT, ///< those of the current round
    STP_PSP_ROOM_WORK, ///< temporary arrays of the current round
    STP_PSP_ROOMS,
} stp_psp_room_use;

/// In each round, a splat has a slot: its position in the order that is split into pieces. The
/// results of a round are numbered block by block.
typedef struct stp_psp_rounds {
    stp_psp_shared shared;
    const stp_psp_metric_table* metric;
    stp_psp_storage storage;
    stp_psp_room rooms[STP_PSP_ROOMS];
    stp_psp_points points; ///< copies in tree order, of the columns that merging reads
    bool in_tree_order;    ///< `shared` uses `points`, so places of the tree index its points
    bool keep_history;
    uint32_t target;
    stp_ellipse* initial; ///< NULL, or receives the points' splats, in merge units
    float alone;          ///< radius of splats without neighbours
    stp_kd_tree tree;     ///< the points; empty after the first round
    uint32_t live;        ///< number of remaining splats
    uint32_t round;
    // results of the previous round
    stp_psp_block* blocks;
    uint32_t block_count, slot_count;
    /// Per slot of the previous round: number of the splat that represents it, then its slot
    uint32_t* survivors;
    // current round
    stp_kd_point* order; ///< `index` is the splat's number; NULL: equal to the slot
    /// Reversed links across seams of the first round: slot << 32 | other slot; ascending by slot
    uint64_t* reverse;
    size_t reverse_count;
    // history
    stp_psp_history* histories;
    size_t history_room;
    uint32_t history_count, merge_count;
} stp_psp_rounds;

/// Initialises without merging. stp_psp_rounds_destroy must always be called.
void stp_psp_rounds_begin(stp_psp_rounds* rounds, stp_context* context,
                          const stp_psp_points* points, const stp_psp_desc* desc, uint32_t target);

/// If all data is in files, copies points into tree order, so that points merged together are
/// stored together.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_order_points(stp_psp_rounds* rounds);

/// Periodically lets the system evict file pages. `number` counts pieces or parts of a loop. Any
/// thread.
void stp_psp_rounds_release(const stp_psp_rounds* rounds, size_t number);

/// Merges until the target is reached or no merge is possible. The caller sets `keep_history`,
/// `initial`, `alone` and `shared`, and makes the tree.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_psp_rounds_destroy,
///         also after a failure
STP_MUST_USE stp_result stp_psp_rounds_run(stp_psp_rounds* rounds);
void stp_psp_rounds_destroy(stp_psp_rounds* rounds);

// Fills pieces with splats: from points in the first round, from blocks in later ones. Makes blocks
// of the remaining splats.

/// Fills a piece with slots [begin, end) of the round. @return false if out of memory
bool stp_psp_load(const stp_psp_rounds* rounds, stp_psp_piece* piece, uint32_t begin, uint32_t end);

/// Makes the block of a merged piece.
/// @param survivors receives for each slot of the piece the block index of the splat that
///         represents it
/// @return false if out of memory or disk space
bool stp_psp_unload(stp_psp_piece* piece, const stp_psp_room* room, stp_psp_block* block,
                    uint32_t* survivors);

/// Errors of the best merges of evenly sampled splats, ascending; disallowed merges are left out.
/// @param errors space for `maximum` values
/// @return their number
uint32_t stp_psp_sample_errors(const stp_psp_rounds* rounds, float* errors, uint32_t maximum);

// Splits the splats of a round into pieces, and carries links over the seams of the last round.

/// A range of slots.
typedef struct stp_psp_range {
    uint32_t begin, end;
} stp_psp_range;

/// Splits all slots into pieces. The first round splits subtrees of the kd-tree; later rounds split at
/// other places and reorder the slots.
/// @param piece_size maximum splats per piece, above 0; STP_KD_LEAF splats are never split
/// @param ranges receives the pieces; the caller frees them
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_split_slots(stp_psp_rounds* rounds, uint32_t piece_size,
                                            stp_psp_range** ranges, uint32_t* count);

/// Converts `survivors` to slots of the current round, after its order is final.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_renumber(stp_psp_rounds* rounds);

/// Discards all links and links each splat with its nearest ones, in both directions. All splats
/// must be in one block.
/// @return STP_OK, STP_ERROR_IO, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_relink(stp_psp_rounds* rounds);

// Merges the histories of all pieces into one order: the forest.

/// Makes the forest of the recorded merges. Merges are ordered by the largest error of the merge
/// and all merges below it, so that splats come before the merges that consume them; ties are in
/// order of creation.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); the caller destroys the forest
STP_MUST_USE stp_result stp_psp_order_merges(const stp_psp_rounds* rounds, stp_psp_forest* forest);
