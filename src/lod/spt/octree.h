// SPDX-License-Identifier: MIT
// The octree of a point tree: points are sorted so that those of each box are consecutive, and
// boxes are divided into octants.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

#include <assert.h>

/// A cube of the octree.
typedef struct stp_octree_cell {
    stp_vec3d center;
    double half;
} stp_octree_cell;

/// Points sorted by octree position; coincident points by index.
typedef struct stp_octree {
    const float* positions; ///< 3 per point; owned by the caller
    uint32_t count;
    stp_octree_cell root;
    uint64_t* items;   ///< per point: octants of the upper levels (32 bits), then its index
    uint64_t* scratch; ///< same size as `items`
} stp_octree;

/// A range of `items`: all points of a cell.
typedef struct stp_octree_box {
    uint32_t begin, end;
    uint32_t level;       ///< number of subdivisions from the root
    stp_octree_cell cell; ///< valid only below the sorted levels
} stp_octree_box;

/// Sorts at least one point by the upper levels, on all threads.
/// @param positions finite
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_octree_destroy, also after a
/// failure
STP_MUST_USE stp_result stp_octree_make(stp_context* context, const float* positions,
                                        uint32_t count, stp_octree* octree);
void stp_octree_destroy(stp_context* context, stp_octree* octree);

/// Index of the point of an item.
static inline uint32_t stp_octree_point(const stp_octree* octree, uint32_t item)
{
    assert(item < octree->count);
    return (uint32_t)octree->items[item];
}

/// Divides a box of two or more points into octants, of which at least two hold points: boxes with
/// one nonempty octant are skipped. Coincident points are split by their order. Below the sorted
/// levels, reorders items within the box. Disjoint boxes may be divided concurrently.
/// @param children space for 8; receives the nonempty ones in order.
/// @return their number
uint32_t stp_octree_divide(const stp_octree* octree, stp_octree_box box,
                           stp_octree_box children[8]);
