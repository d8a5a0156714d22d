// SPDX-License-Identifier: MIT
//
// The visibility buffer: the nearest primitive of each pixel. A pixel is one 64-bit number, depth
// above id, and the smaller number wins. Drawing is a minimum, so the result does not depend on the
// drawing order.
#pragma once

#include "base/math/math.h"

#include <string.h>

#define STP_RASTER_EMPTY UINT64_MAX

typedef struct stp_raster_target {
    uint32_t width, height;
    size_t stride; ///< pixels from row to row; at least width
    uint64_t* pixels;
} stp_raster_target;

/// Packs a pixel. `nearness` is above 0 and grows towards the viewer; along planes it is linear on
/// the screen (1/depth in perspective). `id` is below UINT32_MAX.
static inline uint64_t stp_raster_pixel(float nearness, uint32_t id)
{
    uint32_t bits;
    memcpy(&bits, &nearness, sizeof(bits));
    return (uint64_t)~bits << 32 | id;
}

static inline uint32_t stp_raster_id(uint64_t pixel)
{
    return (uint32_t)pixel;
}

static inline float stp_raster_nearness(uint64_t pixel)
{
    uint32_t bits = ~(uint32_t)(pixel >> 32);
    float nearness;
    memcpy(&nearness, &bits, sizeof(nearness));
    return nearness;
}

/// Object space to screen: (X, Y, N, W) = m * (x, y, z, 1); pixel x = X/W, y = Y/W (y down, in
/// pixels), nearness = N/W. Perspective: N is constant, W is the depth along the view axis.
/// Parallel: W = 1. Draws only where N/W <= nearness_limit (beyond the near plane) and W > 0.
typedef struct stp_raster_matrix {
    float m[4][4];
} stp_raster_matrix;
