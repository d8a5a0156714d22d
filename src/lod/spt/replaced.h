// SPDX-License-Identifier: MIT
// Splats that large triangles replace (Dachsbacher et al. 2003, 3.8).
#pragma once

#include "lod/samples.h"

/// For each sample the level up to which it lies amid triangles that are drawn; 0 where it does
/// not. At lower levels than its own (base/triangle_level.h) a triangle is drawn. A sample beside
/// surface of smaller triangles keeps its splat, because the disk may cover some of that surface.
/// @param corners 9 floats a triangle, in the space of the samples; finite
/// @param levels one a sample
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_spt_find_replaced(stp_context* context,
                                              const stp_method_samples* samples, float step,
                                              const float* corners, uint32_t count, float* levels);
