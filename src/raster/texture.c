// SPDX-License-Identifier: MIT
#include "raster/texture.h"

#include "base/math/color.h"

#include <assert.h>

/// Which texels of the larger level an output texel averages along one axis, and their weights. An
/// odd size n = 2 k + 1 becomes k: each output texel then covers 2 + 1/k texels, so that all count
/// equally.
typedef struct axis_taps {
    uint32_t first, count;
    float weight[3];
} axis_taps;

static axis_taps taps_of(uint32_t size, uint32_t half, uint32_t i)
{
    if (size == 1) {
        return (axis_taps){.first = 0, .count = 1, .weight = {1.0f}};
    }
    if (size % 2 == 0) {
        assert(2 * i + 2 <= size);
        return (axis_taps){.first = 2 * i, .count = 2, .weight = {0.5f, 0.5f}};
    }
    assert(size == 2 * half + 1 && i < half && "the last texel read is size - 1");
    float whole = (float)size, k = (float)half, at = (float)i;
    return (axis_taps){
        .first = 2 * i,
        .count = 3,
        .weight = {(k - at) / whole, k / whole, (at + 1.0f) / whole},
    };
}

/// Adds a texel to the sums of premultiplied colour, alpha, and plain colour (used if alpha is 0
/// everywhere).
static void add_texel(float sum[7], const uint8_t* texel, bool linear, float weight)
{
    float alpha = weight * ((float)texel[3] / 255.0f);
    for (int c = 0; c < 3; ++c) {
        float value = linear ? (float)texel[c] / 255.0f : stp_srgb8_to_linear(texel[c]);
        sum[c] += alpha * value;
        sum[4 + c] += weight * value;
    }
    sum[3] += alpha;
}

static uint8_t to_byte(float value)
{
    value = value > 0.0f ? value : 0.0f;
    value = value < 1.0f ? value : 1.0f;
    return (uint8_t)(value * 255.0f + 0.5f);
}

static void finish_sum(const float sum[7], float out[4])
{
    for (int c = 0; c < 3; ++c) {
        out[c] = stp_min(sum[3] > 0.0f ? sum[c] / sum[3] : sum[4 + c], 1.0f);
    }
    out[3] = stp_min(sum[3], 1.0f);
}

typedef struct reduce_work {
    const uint8_t* from;
    uint8_t* to;
    uint32_t from_width, from_height, width, height;
    bool linear;
} reduce_work;

/// Average of the texels that an output texel covers.
static void average_texels(const reduce_work* work, const axis_taps* across, const axis_taps* down,
                           float color[4])
{
    float sum[7] = {0};
    for (uint32_t j = 0; j < down->count; ++j) {
        const uint8_t* row = work->from + (size_t)(down->first + j) * work->from_width * 4;
        for (uint32_t i = 0; i < across->count; ++i) {
            add_texel(sum, row + (size_t)(across->first + i) * 4, work->linear,
                      down->weight[j] * across->weight[i]);
        }
    }
    finish_sum(sum, color);
}

static void reduce_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const reduce_work* work = user;
    for (size_t y = begin; y < end; ++y) {
        axis_taps down = taps_of(work->from_height, work->height, (uint32_t)y);
        for (uint32_t x = 0; x < work->width; ++x) {
            axis_taps across = taps_of(work->from_width, work->width, x);
            float color[4];
            average_texels(work, &across, &down, color);
            uint8_t* out = work->to + (y * work->width + x) * 4;
            for (int c = 0; c < 3; ++c) {
                out[c] = work->linear ? to_byte(color[c]) : stp_linear_to_srgb8(color[c]);
            }
            out[3] = to_byte(color[3]);
        }
    }
}

stp_result stp_texture_pyramid_create(stp_context* context, const uint8_t* rgba, uint32_t width,
                                      uint32_t height, bool linear, stp_texture_pyramid* pyramid)
{
    *pyramid = (stp_texture_pyramid){.level_count = 1, .linear = linear};
    pyramid->width[0] = width;
    pyramid->height[0] = height;
    pyramid->texels[0] = rgba;
    size_t bytes = 0;
    for (uint32_t level = 1; level < STP_TEXTURE_LEVELS && (width > 1 || height > 1); ++level) {
        width = width > 1 ? width / 2 : 1;
        height = height > 1 ? height / 2 : 1;
        pyramid->width[level] = width;
        pyramid->height[level] = height;
        pyramid->level_count = level + 1;
        bytes += (size_t)width * height * 4;
    }
    if (bytes == 0) {
        return STP_OK;
    }
    pyramid->owned = stp_alloc(context, bytes);
    if (pyramid->owned == NULL) {
        *pyramid = (stp_texture_pyramid){0};
        return stp_fail_memory(context);
    }
    uint8_t* next = pyramid->owned;
    for (uint32_t level = 1; level < pyramid->level_count; ++level) {
        reduce_work work = {
            .from = pyramid->texels[level - 1],
            .to = next,
            .from_width = pyramid->width[level - 1],
            .from_height = pyramid->height[level - 1],
            .width = pyramid->width[level],
            .height = pyramid->height[level],
            .linear = linear,
        };
        stp_parallel_for(context, work.height, 16, reduce_rows, &work);
        pyramid->texels[level] = next;
        next += (size_t)work.width * work.height * 4;
    }
    assert(next == pyramid->owned + bytes && "the levels fill the memory");
    return STP_OK;
}

void stp_texture_pyramid_destroy(stp_context* context, stp_texture_pyramid* pyramid)
{
    stp_free(context, pyramid->owned);
    stp_free(context, pyramid->cutoffs);
    *pyramid = (stp_texture_pyramid){0};
}

/// The texel of an integer coordinate.
static uint32_t wrap(int64_t i, uint32_t size, stp_texture_wrap how)
{
    assert(size != 0);
    int64_t n = size;
    if (i >= 0 && i < n) {
        return (uint32_t)i;
    }
    if (how == STP_TEXTURE_CLAMP) {
        return (uint32_t)(i < 0 ? 0 : i >= n ? n - 1 : i);
    }
    int64_t period = how == STP_TEXTURE_MIRROR ? 2 * n : n;
    int64_t r = i % period;
    r = r < 0 ? r + period : r;
    return (uint32_t)(r < n ? r : period - 1 - r);
}

/// Rounds down. Huge values and NaN become 0; textures repeat anyway.
static int64_t floor_of(float value)
{
    if (!(value > -1e9f && value < 1e9f)) {
        return 0;
    }
    int64_t whole = (int64_t)value;
    return (float)whole > value ? whole - 1 : whole;
}

static float fraction_of(float value, int64_t whole)
{
    float rest = value - (float)whole;
    return rest > 0.0f && rest < 1.0f ? rest : 0.0f; // also for NaN
}

/// The texels around a point: two columns, two rows, and the weights of the second of each.
typedef struct texel_square {
    uint32_t x[2], y[2];
    float fx, fy;
} texel_square;

static texel_square find_square(const stp_texture_pyramid* pyramid, uint32_t level, stp_vec2 uv,
                                bool nearest)
{
    uint32_t width = pyramid->width[level], height = pyramid->height[level];
    float u = uv.x * (float)width, v = uv.y * (float)height;
    u -= nearest ? 0.0f : 0.5f;
    v -= nearest ? 0.0f : 0.5f;
    int64_t x = floor_of(u), y = floor_of(v);
    return (texel_square){
        .x = {wrap(x, width, pyramid->wrap_u), wrap(x + 1, width, pyramid->wrap_u)},
        .y = {wrap(y, height, pyramid->wrap_v), wrap(y + 1, height, pyramid->wrap_v)},
        .fx = nearest ? 0.0f : fraction_of(u, x),
        .fy = nearest ? 0.0f : fraction_of(v, y),
    };
}

static void sample_level(const stp_texture_pyramid* pyramid, uint32_t level, stp_vec2 uv,
                         bool nearest, float weight, float sum[7])
{
    texel_square square = find_square(pyramid, level, uv, nearest);
    for (int j = 0; j < 2; ++j) {
        const uint8_t* row =
            pyramid->texels[level] + (size_t)square.y[j] * pyramid->width[level] * 4;
        for (int i = 0; i < 2; ++i) {
            float w =
                (i == 0 ? 1.0f - square.fx : square.fx) * (j == 0 ? 1.0f - square.fy : square.fy);
            add_texel(sum, row + (size_t)square.x[i] * 4, pyramid->linear, weight * w);
        }
    }
}

static float sample_alpha(const stp_texture_pyramid* pyramid, uint32_t level, stp_vec2 uv,
                          bool nearest)
{
    texel_square square = find_square(pyramid, level, uv, nearest);
    float rows[2];
    for (int j = 0; j < 2; ++j) {
        const uint8_t* row =
            pyramid->texels[level] + (size_t)square.y[j] * pyramid->width[level] * 4 + 3;
        float left = (float)row[(size_t)square.x[0] * 4],
              right = (float)row[(size_t)square.x[1] * 4];
        rows[j] = left + (right - left) * square.fx;
    }
    return (rows[0] + (rows[1] - rows[0]) * square.fy) / 255.0f;
}

float stp_texture_sample_alpha(const stp_texture_pyramid* pyramid, stp_vec2 uv)
{
    return stp_texture_sample_alpha_at(pyramid, uv, 0);
}

float stp_texture_sample_alpha_at(const stp_texture_pyramid* pyramid, stp_vec2 uv, uint32_t level)
{
    assert(level < pyramid->level_count);
    return sample_alpha(pyramid, level, uv, level == 0 && pyramid->nearest);
}

float stp_texture_sample_alpha_of(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint)
{
    assert(pyramid->level_count > 0);
    uint32_t last = pyramid->level_count - 1, level = 0;
    for (; level < last && footprint >= 1.5f; footprint *= 0.5f) {
        level += 1;
    }
    return stp_texture_sample_alpha_at(pyramid, uv, level);
}

void stp_texture_sample(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint,
                        float out[4])
{
    assert(pyramid->level_count > 0);
    float sum[7] = {0};
    uint32_t last = pyramid->level_count - 1, level = 0;
    if (!(footprint > 1.0f)) {
        sample_level(pyramid, 0, uv, pyramid->nearest, 1.0f, sum);
        finish_sum(sum, out);
        return;
    }
    // footprint = 2^level (1 + blend): a logarithm, linear between powers of two
    while (level < last && footprint >= 2.0f) {
        footprint *= 0.5f;
        level += 1;
    }
    float blend = level < last ? footprint - 1.0f : 0.0f;
    assert(blend >= 0.0f && blend <= 1.0f && "weights of two levels");
    sample_level(pyramid, level, uv, false, 1.0f - blend, sum);
    if (blend > 0.0f) {
        sample_level(pyramid, level + 1, uv, false, blend, sum);
    }
    finish_sum(sum, out);
}
