// SPDX-License-Identifier: MIT
// Finding the buckets of points. Every variant gives the same bits.
#pragma once

#include "lod/grid.h"

/// Coordinates with a stride in floats.
typedef struct stp_grid_points {
    const float *x, *y, *z;
    size_t stride;
} stp_grid_points;

typedef struct stp_grid_kernels {
    /// The buckets of the points [begin, end).
    void (*find_buckets)(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                         size_t end, uint32_t* buckets);
} stp_grid_kernels;

/// The kernels for this CPU.
const stp_grid_kernels* stp_grid_kernels_select(void);

extern const stp_grid_kernels stp_grid_kernels_portable;
extern const stp_grid_kernels stp_grid_kernels_avx2;
