// SPDX-License-Identifier: MIT
// The sums over the neighbours of a point, eight at a time: compiled for processors with vectors of four and of eight.
// Each lane adds its own neighbours, so all variants give the same bits.
#pragma once

#include "lod/point_normals_kernels.h"

#include <string.h>

enum { LANES = 8 };
_Static_assert(LANES <= (int)STP_GRID_LANES, "columns may be read so far beyond their end");

typedef float lanes_float __attribute__((vector_size(4 * LANES)));
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES)));

/// Sums of each lane: how many, x, y, z, xx, xy, xz, yy, yz, zz.
typedef struct lane_sums {
    lanes_float of[STP_NORMAL_SUMS];
} lane_sums;

static inline void add_bucket(const stp_grid* grid, uint32_t bucket, const float p[3],
                              float squared_radius, lane_sums* sums)
{
    const lanes_int numbers = {0, 1, 2, 3, 4, 5, 6, 7};
    const lanes_float one = {1, 1, 1, 1, 1, 1, 1, 1};
    uint32_t end = grid->starts[bucket + 1];
    for (uint32_t at = grid->starts[bucket]; at < end; at += LANES) {
        lanes_float x, y, z;
        memcpy(&x, grid->x + at, sizeof(x));
        memcpy(&y, grid->y + at, sizeof(y));
        memcpy(&z, grid->z + at, sizeof(z));
        x -= p[0];
        y -= p[1];
        z -= p[2];
        lanes_int near = (lanes_int)(x * x + y * y + z * z <= squared_radius);
        near &= (lanes_int)(numbers < (int32_t)(end - at));
        x = (lanes_float)((lanes_int)x & near);
        y = (lanes_float)((lanes_int)y & near);
        z = (lanes_float)((lanes_int)z & near);
        sums->of[0] += (lanes_float)((lanes_int)one & near);
        sums->of[1] += x;
        sums->of[2] += y;
        sums->of[3] += z;
        sums->of[4] += x * x;
        sums->of[5] += x * y;
        sums->of[6] += x * z;
        sums->of[7] += y * y;
        sums->of[8] += y * z;
        sums->of[9] += z * z;
    }
}

static inline void sum_lanes(const lane_sums* sums, float out[STP_NORMAL_SUMS])
{
    for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
        float lanes[LANES];
        memcpy(lanes, &sums->of[i], sizeof(lanes));
        for (int step = LANES / 2; step > 0; step /= 2) {
            for (int k = 0; k < step; ++k) {
                lanes[k] += lanes[k + step];
            }
        }
        out[i] = lanes[0];
    }
}

static void sum_neighbours(const stp_grid* grid, float radius, size_t begin, size_t end,
                           float (*out)[STP_NORMAL_SUMS])
{
    for (size_t at = begin; at < end; ++at) {
        const float p[3] = {grid->x[at], grid->y[at], grid->z[at]};
        int32_t cell[3];
        for (int axis = 0; axis < 3; ++axis) {
            cell[axis] = stp_grid_cell(grid, p[axis] - radius);
        }
        lane_sums sums = {0};
        for (int corner = 0; corner < 8; ++corner) {
            uint32_t bucket = stp_grid_bucket(grid, cell[0] + (corner & 1),
                                              cell[1] + (corner >> 1 & 1), cell[2] + (corner >> 2));
            add_bucket(grid, bucket, p, radius * radius, &sums);
        }
        sum_lanes(&sums, out[at - begin]);
    }
}
