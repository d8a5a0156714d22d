// SPDX-License-Identifier: MIT
// The k nearest neighbours of each point of a set: a balanced kd-tree without pointers.
#pragma once

#include "base/context.h"

enum { STP_NEIGHBOURS_MOST = 32 };

/// Lists for each point the nearest other ones, nearest first; of points as near, the lower index first. On all threads; results
/// do not depend on their number.
/// @param positions 3 floats a point, finite
/// @param k 1 to STP_NEIGHBOURS_MOST
/// @param neighbours receives k a point; UINT32_MAX where there are fewer
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_nearest_points(stp_context* context, const float* positions,
                                                uint32_t count, uint32_t k, uint32_t* neighbours);
