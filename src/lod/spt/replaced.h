// SPDX-License-Identifier: MIT
// Splats that are replaced by large triangles (Dachsbacher et al. 2003, 3.8).
#pragma once

#include "lod/samples.h"

/// Finds for each sample the highest level at which drawn triangles surround it; 0 if there is
/// none. A triangle is drawn at levels below its own (base/splats/triangle_level.h). A sample next to
/// surface of smaller triangles keeps its splat, because the disk may cover some of that surface.
/// @param corners 9 floats per triangle, in the space of the samples; finite
/// @param levels receives one per sample
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_spt_find_replaced(stp_context* context,
                                              const stp_method_samples* samples, float step,
                                              const float* corners, uint32_t count, float* levels);
