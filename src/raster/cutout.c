// SPDX-License-Identifier: MIT
#include "raster/cutout.h"

#include <assert.h>
#include <string.h>

// Samples lie between texels, as in a rendered picture: a grid per texel, coarser for large levels.
enum {
    SUBTEXELS = 8, ///< values are multiples of 1 / (255 * SUBTEXELS^2)
    VALUE_ONE = 255 * SUBTEXELS * SUBTEXELS,
    FOUR_PER_SIDE = 1 << 18, ///< largest level with four samples per side and texel
    TWO_PER_SIDE = 1 << 20,
    ERRORS_IN_WHOLE = 50, ///< a level is used if all its shares are wrong by at most 1/50
};

typedef struct histogram {
    uint64_t at_least[VALUE_ONE + 2]; ///< samples with this value or more
    uint64_t all;
} histogram;

static uint32_t wrapped_next(uint32_t i, uint32_t size, stp_texture_wrap how)
{
    return i + 1 < size ? i + 1 : how == STP_TEXTURE_REPEAT ? 0 : size - 1;
}

/// Adds the samples of the square of a texel and its neighbours to the right and below.
static void add_samples(const uint32_t alpha[4], uint32_t side, uint64_t* counts)
{
    assert(side > 0 && SUBTEXELS % side == 0);
    uint32_t step = SUBTEXELS / side;
    for (uint32_t y = step / 2; y < SUBTEXELS; y += step) {
        uint32_t left = alpha[0] * (SUBTEXELS - y) + alpha[2] * y;
        uint32_t right = alpha[1] * (SUBTEXELS - y) + alpha[3] * y;
        for (uint32_t x = step / 2; x < SUBTEXELS; x += step) {
            counts[left * (SUBTEXELS - x) + right * x] += 1;
        }
    }
}

static void count_level(const stp_texture_pyramid* pyramid, uint32_t level, histogram* out)
{
    uint32_t width = pyramid->width[level], height = pyramid->height[level];
    const uint8_t* texels = pyramid->texels[level] + 3;
    size_t size = (size_t)width * height;
    uint32_t side = size <= FOUR_PER_SIDE ? 4 : size <= TWO_PER_SIDE ? 2 : 1;
    bool plain = side == 1 || (level == 0 && pyramid->nearest);
    uint64_t* counts = out->at_least;
    memset(counts, 0, sizeof(out->at_least));
    for (size_t i = 0; plain && i < size; ++i) {
        counts[(size_t)texels[4 * i] * SUBTEXELS * SUBTEXELS] += 1;
    }
    for (uint32_t y = 0; !plain && y < height; ++y) {
        const uint8_t* row = texels + (size_t)y * width * 4;
        const uint8_t* below =
            texels + (size_t)wrapped_next(y, height, pyramid->wrap_v) * width * 4;
        for (uint32_t x = 0; x < width; ++x) {
            size_t here = 4 * (size_t)x, next = 4 * (size_t)wrapped_next(x, width, pyramid->wrap_u);
            const uint32_t alpha[4] = {row[here], row[next], below[here], below[next]};
            add_samples(alpha, side, counts);
        }
    }
    for (size_t i = VALUE_ONE; i-- > 0;) {
        counts[i] += counts[i + 1];
    }
    out->all = counts[0];
    assert(out->all == (plain ? size : size * side * side) && "all samples are counted");
}

static uint64_t difference(uint64_t a, uint64_t b)
{
    return a > b ? a - b : b - a;
}

/// Smallest value of `level` that keeps a share closest to `wanted` of `all`.
static uint32_t find_value(const histogram* level, uint64_t wanted, uint64_t all)
{
    assert(wanted <= all);
    uint32_t low = 0, high = VALUE_ONE + 1; // the first that keeps at most the wanted share
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (level->at_least[middle] * all <= wanted * level->all) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    if (low == 0) {
        return 0;
    }
    assert(low <= VALUE_ONE + 1 && level->at_least[VALUE_ONE + 1] == 0);
    uint32_t lower = low - 1; // keeps too much: go back to where that share begins
    uint64_t much = difference(level->at_least[lower] * all, wanted * level->all);
    uint64_t little = difference(level->at_least[low] * all, wanted * level->all);
    if (little <= much) {
        return low;
    }
    while (lower > 0 && level->at_least[lower - 1] == level->at_least[lower]) {
        lower -= 1;
    }
    return lower;
}

/// Fills the cutoffs of a level. @return whether each keeps about the right share
static bool fill_level(const histogram* whole, const histogram* level, float* out)
{
    bool good = true;
    for (uint32_t i = 0; i < STP_CUTOUT_STEPS; ++i) {
        uint64_t wanted = whole->at_least[i * SUBTEXELS * SUBTEXELS];
        uint32_t value = find_value(level, wanted, whole->all);
        uint64_t apart = difference(level->at_least[value] * whole->all, wanted * level->all);
        good = good && apart * ERRORS_IN_WHOLE <= whole->all * level->all;
        // between two values, so that rounding cannot confuse them
        out[i] = ((float)value - 0.5f) * (1.0f / (float)VALUE_ONE);
    }
    return good;
}

stp_result stp_cutout_prepare(stp_context* context, stp_texture_pyramid* pyramid)
{
    if (pyramid->cutoffs != NULL || pyramid->level_count < 2) {
        return STP_OK;
    }
    histogram* histograms = STP_NEW_ARRAY(context, histogram, 2);
    size_t value_count = STP_CUTOUT_STEPS * (size_t)pyramid->level_count;
    float* made = STP_NEW_ARRAY(context, float, value_count);
    bool good = histograms != NULL && made != NULL;
    if (good) {
        count_level(pyramid, 0, &histograms[0]);
        for (uint32_t i = 0; i < STP_CUTOUT_STEPS; ++i) {
            made[i] = (float)i / 255.0f;
        }
    }
    for (uint32_t level = 1; good && level < pyramid->level_count; ++level) {
        pyramid->cutoffs = made;
        pyramid->cutoff_levels = level;
        count_level(pyramid, level, &histograms[1]);
        good = fill_level(&histograms[0], &histograms[1], made + (size_t)level * STP_CUTOUT_STEPS);
        pyramid->cutoff_levels += good;
    }
    assert(pyramid->cutoff_levels <= pyramid->level_count);
    stp_free(context, histograms);
    if (pyramid->cutoffs == NULL) {
        stp_free(context, made);
        return stp_fail_memory(context);
    }
    return STP_OK;
}

bool stp_cutout_keeps(const stp_texture_pyramid* pyramid, stp_vec2 uv, float footprint, float own,
                      float cutoff)
{
    uint32_t last = pyramid->cutoffs != NULL ? pyramid->cutoff_levels - 1 : 0, level = 0;
    for (; level < last && footprint >= 1.5f; footprint *= 0.5f) {
        level += 1;
    }
    assert(last < pyramid->level_count);
    float alpha = stp_texture_sample_alpha_at(pyramid, uv, level);
    if (level == 0) {
        return own * alpha >= cutoff;
    }
    if (!(cutoff > 0.0f)) {
        return true;
    }
    float step = cutoff / own * 255.0f; // alpha of a texel of level 0 that is just kept
    if (!(step <= 255.0f)) {
        return false;
    }
    uint32_t below = (uint32_t)step;
    below = below < STP_CUTOUT_STEPS - 1 ? below : STP_CUTOUT_STEPS - 2;
    const float* cutoffs = pyramid->cutoffs + (size_t)level * STP_CUTOUT_STEPS + below;
    return alpha >= cutoffs[0] + (cutoffs[1] - cutoffs[0]) * (step - (float)below);
}
