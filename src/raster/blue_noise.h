// SPDX-License-Identifier: MIT
//
// Threshold pattern for transparent surfaces in motion: a pixel is drawn if its threshold is below
// the opacity. For any opacity, the drawn pixels are evenly spread (void-and-cluster, Ulichney
// 1993). Thresholds depend on the pixel, not on time, so the pattern does not flicker. Each surface
// shifts the pattern by its own key, so that surfaces behind show through different pixels than
// those in front.
#pragma once

#include <stdint.h>

enum { STP_BLUE_NOISE_SIDE = 64 };

/// Ranks 0 to 4095, row by row, tileable.
extern const uint16_t* const stp_blue_noise;

/// Key of a surface. `seed`: of the object. `side`: axis of the normal (0 to 2), or axis and sign
/// (0 to 5). `cell`: position along that axis.
uint32_t stp_blue_noise_key(uint32_t seed, uint32_t side, int32_t cell);

/// Threshold, 0 to 1. The thresholds of a pixel over many samples are evenly spread, too.
float stp_blue_noise_threshold(uint32_t key, uint32_t x, uint32_t y, uint32_t sample);
