// SPDX-License-Identifier: MIT
// The power-of-two grid that the positions of a mesh are rounded to.
#pragma once

#include <stdint.h>

/// The step for a mesh: fine enough for its smallest triangles (error at most an eighth of the median edge of any
/// cluster of them, and far less where bytes allow) and for what other meshes put close to it (a 16,384th of its size);
/// so coarse that no coordinate is 2^30 steps or more, and rarely finer than floats of the largest coordinate are. A
/// power of two.
/// Pure; pieces cut from a mesh use the step of the whole, so that their borders round alike.
double stp_choose_grid_step(const float* positions, const uint32_t* indices,
                            uint32_t triangle_count);
