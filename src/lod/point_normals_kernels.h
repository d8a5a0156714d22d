// SPDX-License-Identifier: MIT
#pragma once

#include "lod/grid.h"

enum { STP_NORMAL_SUMS = 10, STP_NORMAL_MATRIX = 6 };

/// Side of a grid's cell over the radius of the search: a little more than the radius, roundings included.
#define STP_NORMAL_CELL 1.001f

/// Every variant gives the same bits.
typedef struct stp_normal_kernels {
    /// For the points [begin, end) of the grid's columns, sums over the points within `radius`, which is less than a
    /// cell: how many, then their offsets x, y, z and the products xx, xy, xz, yy, yz, zz.
    void (*sum_neighbours)(const stp_grid* grid, float radius, size_t begin, size_t end,
                           float (*out)[STP_NORMAL_SUMS]);
    /// For each of `count` such sums of at least one point, a symmetric matrix (xx, xy, xz, yy, yz, zz) that maps every
    /// vector to the direction in which its points lie flattest.
    void (*project)(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                    double (*out)[STP_NORMAL_MATRIX]);
} stp_normal_kernels;

extern const stp_normal_kernels stp_normal_kernels_portable;
extern const stp_normal_kernels stp_normal_kernels_avx2;
