// SPDX-License-Identifier: MIT
//
// What hides splats: how near at least all pixels of a block are, in the picture's own view or that of a picture before.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { STP_RASTER_OCCLUDER_BLOCKS = 4 }; ///< what touches more of them a side is taken to be seen

typedef struct stp_raster_occluder {
    /// The least nearness of each block and of those right of it, below it, and both, row by row (stp_raster_make_windows);
    /// 0: background shows.
    const float* windows;
    uint32_t columns;
    uint32_t shift;      ///< a block is 2^shift pixels a side
    float width, height; ///< of the picture, pixels
    float matrix[3][4];  ///< object space to X, Y, W: pixel = X / W, Y / W; W is depth
    float pixel_scale;   ///< pixels per unit of x/z
    float scale;         ///< object lengths times this are at most as long as they become
    float corner;        ///< distance over depth in a corner of the picture
    float near_distance; ///< nearness = near_distance / depth
    float behind;        ///< what hides counts as if so many times farther
    float apart;         ///< and splats as if so many radii nearer
} stp_raster_occluder;

/// From the least nearness of each block.
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
