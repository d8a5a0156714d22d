// SPDX-License-Identifier: MIT
// The pixel filter (src/draw/cpu/pixel_filter.h), shared by C and GLSL.

// 2k in 65536ths: of pixels that show a splat (k = 0.14), and of others (k = 0.09).
#define PIXEL_WEIGHT_SPLAT 18350u
#define PIXEL_WEIGHT_TRIANGLE 11796u
// Coverage, of 65025, from which on a pixel counts as covered: rounding has lost the rest.
#define PIXEL_COVERED 64900u
