// SPDX-License-Identifier: MIT
// Loops over rows of pixels that compilers turn into vector code. Included once by each variant.
#pragma once

#include "draw/cpu/effects.h"

#include <assert.h>

static void add_max(const float* restrict in, float* restrict out, uint32_t count)
{
    for (uint32_t x = 0; x < count; ++x) {
        out[x] = stp_max(out[x], in[x]);
    }
}

static void add_min(const float* restrict in, float* restrict out, uint32_t count)
{
    for (uint32_t x = 0; x < count; ++x) {
        out[x] = stp_min(out[x], in[x]);
    }
}

static void find_max(const float* in, int32_t reach, float* out, uint32_t count)
{
    assert(reach >= 0);
    memcpy(out, in - reach, count * sizeof(*out));
    for (int32_t k = 1 - reach; k <= reach; ++k) {
        add_max(in + k, out, count);
    }
}

static void find_least(const float* in, int32_t reach, float* out, uint32_t count)
{
    assert(reach >= 0);
    memcpy(out, in - reach, count * sizeof(*out));
    for (int32_t k = 1 - reach; k <= reach; ++k) {
        add_min(in + k, out, count);
    }
}

static void find_gain(const float* restrict nearness, float scale, bool constant,
                      float* restrict out, uint32_t count)
{
    if (constant) {
        for (uint32_t x = 0; x < count; ++x) {
            out[x] = nearness[x] > 0.0f ? scale : 0.0f;
        }
        return;
    }
    for (uint32_t x = 0; x < count; ++x) {
        float quotient = scale / stp_max(nearness[x], 1e-30f);
        out[x] = nearness[x] > 0.0f ? quotient : 0.0f;
    }
}

// Limits the slope that shades, so that silhouettes of distant objects are no darker than near
// ones. In perspective, a step of log depth (Boucheny) differs from a step of depth by less than
// half of its square: this limit is far below.
#define STEEPEST 40.0f
// On a plane, one neighbour falls as much as the other rises. This share of the fall is subtracted;
// otherwise ground near the horizon would be black.
#define PLANE_SHARE 0.75f

/// Rise of one neighbour of a pair, less the fall of the other.
static inline float rise_above(float a, float b)
{
    float rise = a - PLANE_SHARE * stp_max(-b, 0.0f);
    return stp_min(stp_max(rise, 0.0f), STEEPEST);
}

static void add_rise(const float* restrict center, const float* restrict gain,
                     const float* const neighbours[2], float inverse, float* restrict sum,
                     uint32_t count)
{
    const float* restrict one = neighbours[0], * restrict other = neighbours[1];
    for (uint32_t x = 0; x < count; ++x) {
        float factor = gain[x] * inverse;
        float a = (one[x] - center[x]) * factor, b = (other[x] - center[x]) * factor;
        float known_a = one[x] < 0.0f ? 0.0f : a, known_b = other[x] < 0.0f ? 0.0f : b;
        a = one[x] < 0.0f ? -known_b : a; // planes are extrapolated beyond the border
        b = other[x] < 0.0f ? -known_a : b;
        sum[x] += rise_above(a, b) + rise_above(b, a);
    }
}

/// exp(-y) to second order in its reciprocal: pictures must not depend on a math library.
static void make_eye_dome(float* restrict sum, float strength, uint32_t count)
{
    for (uint32_t x = 0; x < count; ++x) {
        float y = sum[x] * strength;
        sum[x] = 1.0f / (1.0f + y * (1.0f + 0.5f * y));
    }
}

/// `numbers`: 1 / distance, minimum rise, 1 / depth beyond which foreground is ignored.
static void add_pair(const float* restrict center, const float* restrict gain,
                     const float* const neighbours[2], const float numbers[3], float* restrict sum,
                     uint32_t count)
{
    const float* restrict one = neighbours[0], * restrict other = neighbours[1];
    float inverse = 0.5f * numbers[0], bias = numbers[1], inverse_reach = numbers[2];
    assert(inverse > 0.0f && bias >= 0.0f && inverse_reach > 0.0f);
    float fall = -2.0f / inverse_reach; // cancels an equal fall on the other side
    for (uint32_t x = 0; x < count; ++x) {
        float a = (one[x] - center[x]) * gain[x], b = (other[x] - center[x]) * gain[x];
        float in_reach = stp_min(stp_max(2.0f - a * inverse_reach, 0.0f), 1.0f) *
                         stp_min(stp_max(2.0f - b * inverse_reach, 0.0f), 1.0f);
        float both = stp_max(a, fall) + stp_max(b, fall);
        float rise = stp_min(stp_max(both * inverse - bias, 0.0f), 1.0f);
        sum[x] += rise * in_reach;
    }
}

static void add_blur(const float* restrict center, const float* restrict gain,
                     const float* restrict neighbour, const float* restrict values, float inverse,
                     float* const sums[2], uint32_t count)
{
    float* restrict sum = sums[0], * restrict weight_sum = sums[1];
    for (uint32_t x = 0; x < count; ++x) {
        float step = (neighbour[x] - center[x]) * gain[x] * inverse;
        float weight = stp_max(1.0f - (step > 0.0f ? step : -step), 0.0f);
        sum[x] += weight * values[x];
        weight_sum[x] += weight;
    }
}

static void spread_blocks(const float* const rows[2], float share, float* restrict mixed,
                          uint32_t columns, float* restrict out, uint32_t count)
{
    const float* restrict above = rows[0], * restrict below = rows[1];
    assert(count <= columns * STP_EFFECT_BLOCK && "blocks cover the row");
    assert(share >= 0.0f && share < 1.0f);
    for (uint32_t i = 0; i < columns; ++i) {
        mixed[i + 1] = above[i] + (below[i] - above[i]) * share;
    }
    mixed[0] = mixed[1]; // half a block before the first middle and after the last
    mixed[columns + 1] = mixed[columns];
    const uint32_t size = STP_EFFECT_BLOCK;
    for (uint32_t i = 0; i <= columns; ++i) { // from the middle of block i - 1 to that of block i
        uint32_t first = i == 0 ? 0 : i * size - size / 2, last = i * size + size / 2;
        last = last < count ? last : count;
        float left = mixed[i], step = (mixed[i + 1] - left) * (1.0f / (float)size);
        float at = i == 0 ? 0.5f + (float)(size / 2) : 0.5f;
        for (uint32_t x = first; x < last; ++x) {
            out[x] = left + step * (at + (float)(x - first));
        }
    }
}

#define EFFECT_KERNELS                                                                             \
    {                                                                                              \
        find_max, find_least, add_max, add_min, find_gain, add_rise, make_eye_dome, add_pair,      \
            add_blur, spread_blocks                                                                \
    }
