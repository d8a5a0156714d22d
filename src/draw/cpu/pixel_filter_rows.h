// SPDX-License-Identifier: MIT
// Loops over rows of pixels that compilers turn into vector code. Included once by each variant.
// All numbers are integers, or single IEEE operations in a fixed order: all variants give the same
// bits.
#pragma once

#include "draw/cpu/pixel_filter.h"
#include "draw/shaders/pixel_filter_constants.h"

#include <math.h>

#define FULL 65025.0f // light of a byte of 255

static void light_row(const uint8_t* restrict pixels, uint16_t* restrict light, uint32_t width)
{
    size_t count = 4 * (size_t)width;
    for (size_t i = 0; i < count; ++i) {
        uint16_t byte = pixels[i]; // of coverage 0 or 255: its square is it times 255
        light[i] = (uint16_t)(byte * byte);
    }
}

static void weigh_row(const uint8_t* restrict kinds, uint16_t* restrict weights, uint32_t width)
{
    const uint64_t lanes = 0x0001000100010001u;
    for (uint32_t x = 0; x < width; ++x) {
        uint64_t four = lanes * (kinds[x] != 0 ? PIXEL_WEIGHT_SPLAT : PIXEL_WEIGHT_TRIANGLE);
        memcpy(weights + 4 * (size_t)x, &four, sizeof(four));
    }
}

/// b (1 - 2k) + (a + c) k, and exactly b if all are equal.
static inline uint16_t mix(uint16_t a, uint16_t b, uint16_t c, uint16_t weight)
{
    uint16_t sides = (uint16_t)((a + c + 1) >> 1);
    uint16_t gain = (uint16_t)((uint32_t)sides * weight >> 16);
    uint16_t loss = (uint16_t)((uint32_t)b * weight >> 16);
    return (uint16_t)(b - loss + gain);
}

static void mix_across(const uint16_t* light, const uint16_t* restrict weights,
                       uint16_t* restrict out, uint32_t width)
{
    const uint16_t *before = light - 4, *behind = light + 4;
    size_t count = 4 * (size_t)width;
    for (size_t i = 0; i < count; ++i) {
        out[i] = mix(before[i], light[i], behind[i], weights[i]);
    }
}

static inline uint8_t root(float light)
{
    return (uint8_t)(int32_t)(sqrtf(light) + 0.5f);
}

/// The pixel of one that is neither open nor covered: light is divided by coverage.
static inline void finish_border(const uint16_t* light, uint8_t* pixel)
{
    float coverage = (float)light[3], scale = FULL / coverage;
    for (int c = 0; c < 3; ++c) {
        pixel[c] = root(stp_min((float)light[c] * scale, FULL));
    }
    pixel[3] = (uint8_t)(int32_t)(coverage * (1.0f / 255.0f) + 0.5f);
}

static void mix_down(const uint16_t* const rows[3], const uint16_t* restrict weights,
                     uint16_t* restrict light, uint8_t* restrict pixels, uint32_t width)
{
    const uint16_t* restrict above = rows[0], * restrict here = rows[1], * restrict below = rows[2];
    size_t count = 4 * (size_t)width;
    for (size_t i = 0; i < count; ++i) {
        light[i] = mix(above[i], here[i], below[i], weights[i]);
    }
    for (size_t i = 0; i < count; ++i) {
        pixels[i] = root((float)light[i]);
    }
    for (size_t i = 0; i < count; i += 4) {
        if (light[i + 3] - 1u < PIXEL_COVERED - 1u) {
            finish_border(light + i, pixels + i);
        }
    }
}

#define PIXEL_KERNELS                                                                              \
    {                                                                                              \
        light_row, weigh_row, mix_across, mix_down                                                 \
    }
