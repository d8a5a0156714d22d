// SPDX-License-Identifier: MIT
//
// Smooth noise: lattice values interpolated by a quintic, so the slope is continuous. In [-1, 1].
#pragma once

#include <stdint.h>

double noise2(uint64_t seed, double x, double y);

/// Sum of octaves, each twice the frequency and half the amplitude of the previous; in about [-1,
/// 1].
double noise2_octaves(uint64_t seed, double x, double y, int count);
double noise3_octaves(uint64_t seed, double x, double y, double z, int count);
