// SPDX-License-Identifier: MIT
// A distant fine pattern, moved by fractions of a pixel: with the colours of the pyramid, each the
// mean over the area of a splat, pictures change less than with the splats' own colours.
#include "support_picture.h"
#include "tests.h"

#include "base/math/color.h"
#include "base/math/rng.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE, BYTES = SIDE * SIDE * 4, LOG_SIDE = 7, STEPS = 16 };

static uint8_t pattern(uint32_t x, uint32_t y)
{
    return stp_rng_hash(9, y << LOG_SIDE | x) % 2 == 0 ? 20 : 235;
}

/// Mean of the pattern over a cell of (1 << (LOG_SIDE - level)) squares per side, in linear light.
static uint8_t mean(uint32_t x, uint32_t y, uint32_t level)
{
    uint32_t size = 1u << (LOG_SIDE - level);
    float sum = 0.0f;
    for (uint32_t k = 0; k < size * size; ++k) {
        uint32_t at_x = (x & ~(size - 1)) + k % size, at_y = (y & ~(size - 1)) + k / size;
        sum += stp_srgb8_to_linear(pattern(at_x, at_y));
    }
    return stp_linear_to_srgb8(sum / (float)(size * size));
}

/// Colours for each prefix of 4^k.
static bool color_octaves(stp_context* context, stp_splats* s, bool pyramid)
{
    uint32_t total = 0;
    s->octave_count = LOG_SIDE + 1;
    for (uint32_t k = 0; k <= LOG_SIDE; ++k) {
        s->octave_ends[k] = 1u << (2 * k);
        total += s->octave_ends[k];
    }
    stp_free(context, s->colors);
    stp_free(context, s->coverages);
    s->colors = STP_NEW_ARRAY(context, uint8_t, 3 * (size_t)total);
    s->coverages = STP_NEW_ARRAY(context, uint8_t, total);
    if (s->colors == NULL || s->coverages == NULL) {
        return false;
    }
    memset(s->coverages, 255, total);
    size_t at = 0;
    for (uint32_t level = 0; level <= LOG_SIDE; ++level) {
        for (uint32_t i = 0; i < s->octave_ends[level]; ++i, ++at) {
            uint32_t x = s->positions[3 * i] >> (16 - LOG_SIDE),
                     y = s->positions[3 * i + 1] >> (16 - LOG_SIDE);
            memset(s->colors + 3 * at, mean(x, y, pyramid ? level : LOG_SIDE), 3);
        }
    }
    return true;
}

/// Mean change of a pixel between steps.
static double measure_change(bool pyramid, stp_filter filter)
{
    static uint8_t before[BYTES];
    made_picture p;
    double change = 0.0, count = 0.0;
    if (!made_picture_begin(&p, NULL, 1)) {
        return -1.0;
    }
    made_picture_add(&p, 0.0, (stp_vec3d){0}, (const uint8_t[3]){0});
    made_free_set(p.context, &p.scene.sets[0]);
    p.scene.sets[0] = made_square_set(p.context, LOG_SIDE, (const uint8_t[3]){0});
    bool made = color_octaves(p.context, &p.scene.sets[0], pyramid);
    p.view.eye.z = 8; // the square is 20 pixels a side
    p.style.filter = filter;
    made = made && made_picture_open(&p) == STP_OK;
    for (int step = 0; made && step <= STEPS; ++step) {
        p.view.eye.x = p.view.target.x = 0.1 / 8.0 * step; // an eighth of a pixel
        p.view.eye.y = p.view.target.y = 0.03 / 8.0 * step;
        made = made_picture_draw(&p) == STP_OK && p.stats.splats > 100;
        for (int i = 0; step > 0 && i < SIDE * SIDE; ++i) {
            int x = i % SIDE, y = i / SIDE;
            if (x >= 26 && x < 38 && y >= 26 && y < 38) { // never its border
                change += abs(p.pixels[4 * i] - before[4 * i]);
                count += 1.0;
            }
        }
        memcpy(before, p.pixels, BYTES);
    }
    made_picture_end(&p);
    return made ? change / count : -1.0;
}

void test_shimmer_is_less_with_the_pyramid(test_state* test)
{
    double with = measure_change(true, STP_FILTER_NONE);
    double without = measure_change(false, STP_FILTER_NONE);
    double filtered = measure_change(true, STP_FILTER_EWA);
    CHECK(filtered > 0.0 && filtered < with && with < 0.7 * without);
}
