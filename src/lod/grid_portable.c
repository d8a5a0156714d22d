// SPDX-License-Identifier: MIT
#include "lod/grid.h"

#include <assert.h>

static void find_buckets(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                         size_t end, uint32_t* buckets)
{
    assert(begin <= end && points->stride > 0);
    for (size_t i = begin; i < end; ++i) {
        size_t at = i * points->stride;
        buckets[i] =
            stp_grid_bucket(grid, stp_grid_cell(grid, points->x[at]),
                            stp_grid_cell(grid, points->y[at]), stp_grid_cell(grid, points->z[at]));
    }
}

const stp_grid_kernels stp_grid_kernels_portable = {find_buckets};
