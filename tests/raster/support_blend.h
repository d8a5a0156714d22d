// SPDX-License-Identifier: MIT
// Shared by the tests of blended splats.
#pragma once

#include "base/math/rng.h"
#include "raster/splats_blend.h"

static inline double blend_uniform(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53);
}

/// A colour derived from a splat's index.
static inline void blend_color_splats(void* user, uint32_t first, uint32_t count, const float* x,
                                      const float* y, uint32_t (*out)[3])
{
    (void)user, (void)x, (void)y;
    for (uint32_t i = 0; i < count; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            out[i][k] = (uint32_t)(stp_rng_hash(first + i, k) % STP_BLEND_COLORS);
        }
    }
}
