// SPDX-License-Identifier: MIT
// The octree of a cloud over the position grid of its set (Bhakar, Luo, Mudur 2004, 3.1): cubes are
// divided until they contain few points that lie in a plane.
#pragma once

#include "base/core/context.h"
#include "base/splats/splat_columns.h"

enum { STP_LEAF_NEIGHBOURS_MAX = 32 };

/// Parameters of the octree and of normal estimation.
typedef struct stp_leaf_desc {
    uint32_t budget;  ///< maximum points of a leaf above `minimum`: the paper's max_point_budget
    uint32_t minimum; ///< cubes with at most this many points are not divided
    /// Maximum l0 / (l0 + l1 + l2) of a flat leaf; 0.005 or 0.001 (Table 1, Figure 1)
    float flatness;
    /// K, 1 to STP_LEAF_NEIGHBOURS_MAX: neighbouring leaves to which a leaf's orientation spreads
    uint32_t neighbours;
    /// K1: approximate number of neighbours from which the normal of a point without one is
    /// estimated
    uint32_t normal_neighbours;
    /// 1 to STP_LEAF_SCALES_MAX: number of region sizes that must show a feature
    /// (lod/stochastic/leaf_passes.h)
    uint32_t scales;
    uint32_t sample; ///< maximum size of the random sample that represents a region
} stp_leaf_desc;

stp_leaf_desc stp_leaf_desc_default(void);

/// A leaf: points [begin, end) of `order`.
typedef struct stp_leaf_cell {
    uint32_t begin, end;
    uint16_t corner[3];
    uint8_t depth; ///< subdivisions, at most STP_LEAF_DEPTH_MAX
} stp_leaf_cell;

typedef struct stp_leaf_octree {
    uint32_t leaf_count;
    stp_leaf_cell* leaves; ///< sorted along the Morton curve
    uint32_t* order;       ///< points, leaf by leaf; random order within each leaf
} stp_leaf_octree;

/// @param positions 3 per point, on the grid
/// @param seed seed of the random samples and orders
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_leaf_octree_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_leaf_octree_make(stp_context* context, const uint16_t* positions,
                                             uint32_t count, const stp_leaf_desc* desc,
                                             uint64_t seed, stp_leaf_octree* octree);
void stp_leaf_octree_destroy(stp_context* context, stp_leaf_octree* octree);
