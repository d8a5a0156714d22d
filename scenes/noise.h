// SPDX-License-Identifier: MIT
//
// Smooth random functions of place: values of a lattice, blended by a quintic so that slopes join. In [-1, 1].
#pragma once

#include <stdint.h>

double noise2(uint64_t seed, double x, double y);
double noise3(uint64_t seed, double x, double y, double z);

/// Octaves, each twice as fine and half as high as the one before; in about [-1, 1].
double noise2_octaves(uint64_t seed, double x, double y, int count);
double noise3_octaves(uint64_t seed, double x, double y, double z, int count);
