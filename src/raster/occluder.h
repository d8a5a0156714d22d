// SPDX-License-Identifier: MIT
//
// Occlusion culling of splats: a lower bound on the nearness of all pixels in each block, from this
// view or an earlier picture.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { STP_RASTER_OCCLUDER_BLOCKS = 4 }; ///< splats touching more blocks per side count as visible

typedef struct stp_raster_occluder {
    /// Least nearness of each block and its neighbours to the right, below, and diagonal, row by
    /// row (stp_raster_make_windows); 0: the background is visible.
    const float* windows;
    uint32_t columns;
    uint32_t shift;      ///< a block is 2^shift pixels wide and high
    float width, height; ///< size of the picture, pixels
    float matrix[3][4];  ///< object space to X, Y, W: pixel = X / W, Y / W; W is depth
    float pixel_scale;   ///< pixels per unit of x/z
    float scale;         ///< upper bound on the scale of object lengths
    float corner;        ///< distance over depth in a corner of the picture
    float near_distance; ///< nearness = near_distance / depth
    float behind;        ///< factor on the distance of occluders
    float apart;         ///< splats count as this many radii nearer
} stp_raster_occluder;

/// Builds the windows from the least nearness of each block.
static inline void stp_raster_make_windows(const float* blocks, uint32_t columns, uint32_t rows,
                                           float* windows)
{
    for (uint32_t y = 0; y < rows; ++y) {
        const float* above = blocks + (size_t)y * columns;
        const float* below = y + 1 < rows ? above + columns : above;
        for (uint32_t x = 0; x < columns; ++x) {
            uint32_t right = x + 1 < columns ? x + 1 : x;
            float a = above[x] < below[x] ? above[x] : below[x];
            float b = above[right] < below[right] ? above[right] : below[right];
            *windows++ = a < b ? a : b;
        }
    }
}
