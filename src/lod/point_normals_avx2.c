// SPDX-License-Identifier: MIT
#if defined(__x86_64__)

#include "lod/point_normals_kernel.h"

void stp_sum_neighbours_avx2(const stp_grid* grid, float radius, size_t begin, size_t end,
                             float (*out)[STP_NORMAL_SUMS])
{
    sum_neighbours(grid, radius, begin, end, out);
}

#endif
