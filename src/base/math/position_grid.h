// SPDX-License-Identifier: MIT
// The power-of-two grid to which the positions of a mesh are rounded.
#pragma once

#include <stdint.h>

/// Chooses the step for a mesh, a power of two. Fine enough for its smallest triangles (error at
/// most an eighth of the median edge of any cluster of them, and usually far less) and for geometry
/// of other meshes close to it (1/16384 of its size). Coarse enough that every coordinate is below
/// 2^30 steps; rarely finer than the float precision of the largest coordinate. Pure. Pieces split
/// from a mesh use the step of the whole mesh, so that their borders round alike.
double stp_choose_grid_step(const float* positions, const uint32_t* indices,
                            uint32_t triangle_count);
