// SPDX-License-Identifier: MIT
// From numbers of splats of leaves to items with runs.
#pragma once

#include "select/select_internal.h"

/// A leaf, or several along the curve, and how many of its splats are drawn: the first ones in the order of octaves.
typedef struct stp_cue_cell {
    uint32_t first, last; ///< places of the row of splats (base/leaf_runs.h)
    uint32_t count;       ///< splats drawn, 1 to last - first
    uint32_t
        growth; ///< splats are larger by the square root of 2 to so much; set by stp_cue_add_items
} stp_cue_cell;

/// Octaves of a set that make up about a part of each leaf: the share of splats is nearest to `share`, at most that of `here`
/// splats. @return how many octaves
uint32_t stp_cue_octaves(const stp_splats* set, double share, uint32_t here);

/// The places of a row before `last`, and not before `first`, that are in the first `octaves` octaves.
uint32_t stp_cue_count(const stp_splats* set, uint32_t first, uint32_t last, uint32_t octaves);

/// Appends an item for each size of splats that the cells have; each has the fields of `item` besides. Cells are along the curve.
STP_MUST_USE stp_result stp_cue_add_items(stp_selection* s, const stp_splats* set,
                                          stp_cue_cell* cells, size_t count, stp_draw_item item,
                                          stp_depth_range drawn);
