// SPDX-License-Identifier: MIT
// The k nearest neighbours of each point of a set.
#pragma once

#include "lod/psp/kd_tree.h"

/// Converts the result of stp_kd_nearest to the format of stp_find_nearest_points, in k entries.
void stp_list_neighbours(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                         uint32_t count, uint32_t k, uint32_t* neighbours);

/// Lists for each point its nearest other points, nearest first, ties by index. If several points
/// tie for the last entry, any of them may be listed; which one depends on the points alone. Runs
/// on all threads; results do not depend on their number.
/// @param positions 3 floats per point, read as stp_kd_tree_make does
/// @param k 1 to STP_NEIGHBOURS_MAX
/// @param neighbours receives k entries per point; UINT32_MAX for missing ones
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_nearest_points(stp_context* context, const float* positions,
                                                uint32_t count, uint32_t k, uint32_t* neighbours);
