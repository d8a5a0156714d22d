// SPDX-License-Identifier: MIT
// The octree of a cloud over the position grid of its set (Bhakar, Luo, Mudur 2004, 3.1). Cubes are divided until they hold few
// points in nearly a plane.
#pragma once

#include "base/context.h"

#include <stipple/surfels.h>

enum { STP_LEAF_NEIGHBOURS_MOST = 32 };

/// When division ends, and how normals are found.
typedef struct stp_leaf_desc {
    uint32_t budget; ///< maximum points per leaf, at least `least`: the paper's max_point_budget
    uint32_t least;  ///< a cube of at most this many points is not divided, flat or not
    float
        flatness; ///< maximum l0 / (l0 + l1 + l2) of a flat leaf; 0.005 or 0.001 (Table 1, Figure 1)
    uint32_t
        neighbours; ///< K, 1 to STP_LEAF_NEIGHBOURS_MOST: leaves that each leaf passes its orientation on to
    uint32_t
        normal_neighbours; ///< K1: approximate number of neighbours that a normal is estimated from
    uint32_t
        scales; ///< 1 to STP_LEAF_SCALES_MOST: number of region sizes that must show a feature (lod/stochastic/scales.h)
    uint32_t sample; ///< maximum number of random points that decide whether a region is flat
} stp_leaf_desc;

stp_leaf_desc stp_leaf_desc_default(void);

/// A leaf holds points [begin, end) of the order.
typedef struct stp_leaf_cell {
    uint32_t begin, end;
    uint16_t corner[3];
    uint8_t depth;
} stp_leaf_cell;

typedef struct stp_leaf_octree {
    uint32_t leaf_count;
    stp_leaf_cell* leaves; ///< along the Morton curve
    uint32_t* order;       ///< the points, leaf by leaf, in random order within each leaf
} stp_leaf_octree;

/// @param positions 3 a point, on the grid
/// @param seed of the random orders
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_leaf_octree_destroy, also after a failure
STP_MUST_USE stp_result stp_leaf_octree_make(stp_context* context, const uint16_t* positions,
                                             uint32_t count, const stp_leaf_desc* desc,
                                             uint64_t seed, stp_leaf_octree* octree);
void stp_leaf_octree_destroy(stp_context* context, stp_leaf_octree* octree);
