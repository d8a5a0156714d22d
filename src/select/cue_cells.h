// SPDX-License-Identifier: MIT
// Turns splat counts per leaf into items with runs.
#pragma once

#include "select/select_internal.h"

/// A leaf, or consecutive leaves along the curve, and the number of its splats that are drawn: the
/// first ones in octave order.
typedef struct stp_cue_cell {
    uint32_t first, last; ///< places of the row of splats (base/splats/leaf_runs.h)
    uint32_t count;       ///< splats drawn, 1 to last - first
    // set by stp_cue_add_items:
    uint32_t growth; ///< splats are larger by a power of the fourth root of 2: the exponent
    uint32_t next;   ///< the next cell with the same growth
} stp_cue_cell;

/// Finds the number of octaves whose share of the set's splats is nearest to `share`, at most that
/// of `here` splats. @return number of octaves
uint32_t stp_cue_octaves(const stp_splats* set, double share, uint32_t here);

/// Number of places in [first, last) of a row that are in the first `octaves` octaves.
uint32_t stp_cue_count(const stp_splats* set, uint32_t first, uint32_t last, uint32_t octaves);

/// Appends one item per splat size of the cells, otherwise a copy of `item`. Cells are in curve
/// order.
STP_MUST_USE stp_result stp_cue_add_items(stp_selection* s, const stp_splats* set,
                                          stp_cue_cell* cells, size_t count, stp_draw_item item,
                                          stp_depth_range drawn);
