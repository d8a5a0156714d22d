// SPDX-License-Identifier: MIT
// The points to be ordered, as given and as the search structures use them.
#pragma once

#include "order/tree.h"

#include <assert.h>

typedef struct stp_points {
    const float* positions; ///< 3 per point
    const float* normals;   ///< 3 per point, or NULL
    uint32_t count;
    stp_box box; ///< bounding box of the positions as given
    /// A power of two: positions times it span about 1, so that squares cannot overflow
    float scale;
} stp_points;

/// A point's position, scaled.
static inline stp_vec3 stp_points_scaled(const stp_points* points, uint32_t id)
{
    assert(id < points->count && points->scale > 0.0f);
    const float* p = points->positions + 3 * (size_t)id;
    return (stp_vec3){p[0] * points->scale, p[1] * points->scale, p[2] * points->scale};
}

/// Computes box and scale. @return STP_OK, or STP_ERROR_ARGUMENT if a position is not finite
/// (logged)
STP_MUST_USE stp_result stp_points_measure(stp_points* points, const stp_team* team);

/// Fills the tree's leaves with the scaled points along a Morton curve, all gaps infinite, and
/// `ids` with the index of the point at each position of the tree. Points in the same cell of the
/// curve (2^-20 of the box) keep the order of the input; if the tree has normals, those of each
/// side do.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_points_sort(const stp_points* points, const stp_team* team,
                                        stp_tree* tree, uint32_t* ids);
