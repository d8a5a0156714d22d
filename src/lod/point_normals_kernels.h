// SPDX-License-Identifier: MIT
#pragma once

#include "lod/grid.h"

enum { STP_NORMAL_SUMS = 10 };

/// For the points [begin, end) of the grid's columns, sums over the points within `radius`, which is at most half a
/// cell: how many, then their offsets x, y, z and the products xx, xy, xz, yy, yz, zz. Every variant gives the same bits.
typedef void stp_sum_neighbours(const stp_grid* grid, float radius, size_t begin, size_t end,
                                float (*out)[STP_NORMAL_SUMS]);

stp_sum_neighbours stp_sum_neighbours_portable;
stp_sum_neighbours stp_sum_neighbours_avx2;
