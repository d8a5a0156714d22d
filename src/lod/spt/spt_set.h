// SPDX-License-Identifier: MIT
// Method `spt`: a point tree over evenly spread samples, stored as a sequence of splats with shapes
// and ranges of levels (Dachsbacher et al. 2003, 3.1 to 3.7).
#pragma once

#include "base/splat_columns.h"
#include "lod/spt/point_tree.h"

typedef struct stp_spt_desc {
    stp_tree_desc tree;
    const float* corners; ///< of the node's large triangles (replaced.h), 9 floats each
    uint32_t triangle_count;
} stp_spt_desc;

/// Makes the splats of a node from its evenly spread samples: a set of method `blue`, of which all
/// surfels become leaves, as large as they are drawn. Ranges and the prefix table hold half errors:
/// a splat is drawn where the radius that is wanted lies within its range. Splats lie by falling
/// highest level; leaves count as exact, and from the table's last radius on the samples are too
/// few. A splat that is drawn only at levels at which large triangles are drawn all around its
/// samples is marked: they replace it. Arrays of the result come from stp_alloc.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_spt_make(stp_context* context, const stp_splats* samples,
                                     const stp_spt_desc* desc, stp_splats* splats);
