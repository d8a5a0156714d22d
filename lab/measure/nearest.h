// SPDX-License-Identifier: MIT
// Exact nearest neighbours among a fixed set of points: a balanced kd-tree without pointers.
#pragma once

#include "base/core/context.h"

typedef struct stp_nearest {
    uint32_t count;
    float* positions; ///< 3 each, in the tree's order: the middle of each range splits it
    uint32_t* ids;    ///< their indices in the input
    uint8_t* axes;    ///< the axis that each splits
} stp_nearest;

/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_nearest_create(stp_context* context, stp_nearest* tree,
                                           const float* points, uint32_t count);
void stp_nearest_destroy(stp_context* context, stp_nearest* tree);

/// Squared distance from a point to the nearest one whose index is not `except` (UINT32_MAX: any);
/// infinity if there is none. Any thread.
double stp_nearest_squared(const stp_nearest* tree, const float* point, uint32_t except);
