// SPDX-License-Identifier: MIT
// How many pixels triangles cover, as a measure of what a simplification loses.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

enum { STP_COVERED_RESOLUTION_MAX = 1024 };

/// Draws triangles along the three axes, by parallel projection, and counts covered pixels.
/// @param positions   3 per vertex, finite
/// @param box         contains all triangles; pictures of other triangles in the same box compare
/// @param resolution  pixels along the longest side of the box, 1 to STP_COVERED_RESOLUTION_MAX
/// @param count       receives the number, of all three pictures
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). May run inside a parallel loop
STP_MUST_USE stp_result stp_count_covered_pixels(stp_context* context, const float* positions,
                                                 uint32_t vertex_count, const uint32_t* indices,
                                                 uint32_t triangle_count, stp_box box,
                                                 uint32_t resolution, uint64_t* count);
