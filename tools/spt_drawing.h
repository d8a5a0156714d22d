// SPDX-License-Identifier: MIT
// Point trees drawn on the processor, one thread, for `stipple bench spt`: by the recursive traversal, which hands what it
// selects to the raster in blocks as QSplat does, and as a sequence, with and without groups.
#pragma once

#include "lod/spt/point_tree.h"

#include <stipple/surfels.h>

typedef struct spt_drawing spt_drawing;

/// Sums over views. Times are of selecting and drawing; of the sequence, those of its test alone beside them.
typedef struct spt_times {
    uint64_t traversal_splats, sequence_splats, group_splats;
    double traversal_ms, sequence_ms, test_ms, group_ms, group_test_ms;
} spt_times;

/// `tree` was made of `samples`, and outlives the drawing. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result spt_drawing_create(stp_context* context, const stp_point_tree* tree,
                                           const stp_surfels* samples, spt_drawing** drawing);
void spt_drawing_destroy(spt_drawing* drawing);

/// Adds what a view of 1080 rows takes. `nodes` has room for all leaves.
void spt_drawing_measure(spt_drawing* drawing, const stp_point_tree* tree, uint32_t* nodes,
                         const stp_tree_view* view, stp_vec3d target, spt_times* times);
