// SPDX-License-Identifier: MIT
// Method `spt`: a point tree over evenly spaced samples, stored as a sequence of splats with shapes
// and ranges of levels (Dachsbacher et al. 2003, sections 3.1 to 3.7).
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/spt/point_tree.h"

/// Columns of all sets of the method. With STP_TREE_SPLIT, sets have STP_SPLATS_ERRORS too.
enum {
    STP_SPT_COLUMNS =
        STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS | STP_SPLATS_REPLACED
};

typedef struct stp_spt_desc {
    stp_tree_desc tree;
    const stp_shading* shadings; ///< of the samples, for their growths; NULL: none
    const float* corners;        ///< 9 floats per large triangle of the node (node_splats.h)
    uint32_t triangle_count;
} stp_spt_desc;

/// Makes the splats of a node from its evenly spaced samples, a set of method `blue`. Each surfel
/// becomes a leaf with the size at which it is drawn, with its growth. Ranges and the prefix table
/// hold half errors: a splat is drawn if the requested radius lies in its range. Splats are sorted
/// by descending highest level, and between two breakpoints of the table by direction and position.
/// Leaves count as exact; beyond the table's last radius the samples are too sparse. A splat is marked as
/// replaced if it is drawn only at levels at which large triangles surround its samples. Arrays of
/// the result are allocated with stp_alloc.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_spt_make(stp_context* context, const stp_splats* samples,
                                     const stp_spt_desc* desc, stp_splats* splats);
