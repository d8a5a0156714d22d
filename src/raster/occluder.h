// SPDX-License-Identifier: MIT
//
// What hides splats: how near at least all pixels of a block are, in the picture's own view or that of a picture before.
#pragma once

#include <stdbool.h>
#include <stdint.h>

enum { STP_RASTER_OCCLUDER_BLOCKS = 4 }; ///< what touches more of them a side is taken to be seen

typedef struct stp_raster_occluder {
    const float* nearness; ///< the least of each block, row by row; 0: background shows
    uint32_t columns;
    uint32_t shift;      ///< a block is 2^shift pixels a side
    float width, height; ///< of the picture, pixels
    float matrix[3][4];  ///< object space to X, Y, W: pixel = X / W, Y / W; W is depth
    float pixel_scale;   ///< pixels per unit of x/z
    float scale;         ///< object lengths times this are at most as long as they become
    float corner;        ///< distance over depth in a corner of the picture
    float near_distance; ///< nearness = near_distance / depth
    float behind;        ///< what hides counts as if so many times farther
} stp_raster_occluder;
