// SPDX-License-Identifier: MIT
//
// A pattern of thresholds for transparent surfaces in motion: pixels whose threshold is below the opacity are drawn. Of any
// opacity they are spread evenly (void-and-cluster, Ulichney 1993), and thresholds depend on the pixel, not on the time,
// so that the pattern does not flicker. Each surface has the pattern shifted by its own key: what lies behind shows through
// other pixels than what is in front.
#pragma once

#include <stdint.h>

enum { STP_BLUE_NOISE_SIDE = 64 };

/// Ranks 0 to 4095, row by row, on a torus.
extern const uint16_t* const stp_blue_noise;

/// The key of a surface: `seed` of the thing, `side` 0 to 5 the axis (and sign) of its normal, `cell` where it lies along it.
uint32_t stp_blue_noise_key(uint32_t seed, uint32_t side, int32_t cell);

/// 0 to 1. The thresholds of a pixel over many samples are spread evenly, too.
float stp_blue_noise_threshold(uint32_t key, uint32_t x, uint32_t y, uint32_t sample);
