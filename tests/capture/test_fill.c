// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "capture/fill_kernel.h"

#include <string.h>

enum { SIDE = 90, PIXELS = SIDE * SIDE, WORDS_A_ROW = (SIDE + 31) / 32 };

// A further view along -z at bumpy ground, and two main views that saw most of it: one from the
// same side, and one at a slant. One unit is one pixel.
typedef struct fill_case {
    stp_fill_query query;
    stp_fill_word words[2][SIDE * WORDS_A_ROW];
    stp_fill_surface surface[2 * PIXELS];
    uint64_t pixels[PIXELS];
} fill_case;

static float random_float(uint64_t seed, uint64_t i)
{
    return (float)(stp_rng_hash(seed, i) >> 40) / 16777216.0f;
}

static void make_case(fill_case* c, uint64_t seed)
{
    memset(c, 0, sizeof(*c));
    c->query = (stp_fill_query){
        .x = {1, 0, 0}, .y = {0, 1, 0}, .z = {0, 0, 100}, .toward = {0, 0, 1}, .view_count = 2};
    c->query.surface = c->surface;
    uint32_t count = 0;
    for (int v = 0; v < 2; ++v) {
        c->query.looks[v] = (stp_fill_view){.x = {1, 0, v == 1 ? 0.3f : 0.0f},
                                            .y = {0, 1, 0},
                                            .z = {0, 0, 0.01f},
                                            .x_shift = 0.25f,
                                            .pixels_per_nearness = 100.0f,
                                            .width = SIDE,
                                            .height = SIDE,
                                            .words_per_row = WORDS_A_ROW,
                                            .words = c->words[v]};
        for (uint32_t i = 0; i < PIXELS; ++i) {
            stp_fill_word* word = &c->words[v][i / SIDE * WORDS_A_ROW + i % SIDE / 32];
            word->first = i % SIDE % 32 == 0 ? count : word->first;
            if (random_float(seed + 1, i + PIXELS * (uint64_t)v) < 0.8f) {
                word->covered |= (uint32_t)1 << i % SIDE % 32;
                uint32_t normal = (uint32_t)stp_rng_hash(seed + 2, count) & 0x3FFFFFFFu;
                float nearness = 1.4f + 0.03f * random_float(seed + 3, count);
                c->surface[count++] = (stp_fill_surface){nearness, normal};
            }
        }
    }
    for (uint32_t i = 0; i < PIXELS; ++i) {
        bool empty = random_float(seed + 4, i) < 0.3f;
        float nearness = 1.4f + 0.03f * random_float(seed + 5, i) - 1.5f;
        c->pixels[i] = empty ? STP_RASTER_EMPTY : stp_raster_pixel(nearness + 1.5f, i);
    }
    c->query.origin[2] = -150.0f;
}

// The rule in double precision: 1 known, 0 not, -1 too close to call.
static int expect_known(const fill_case* c, uint32_t pixel)
{
    int best = 0;
    double nearness = (double)stp_raster_nearness(c->pixels[pixel]);
    double p[3] = {pixel % SIDE + 0.5, pixel / SIDE + 0.5, 100.0 * nearness - 150.0};
    for (uint32_t v = 0, candidate = 0; v < 2; ++v) {
        double x = p[0] + (v == 1 ? 0.3 : 0.0) * p[2] + 0.25, y = p[1];
        for (uint32_t i = 0; i < PIXELS; ++i) {
            if ((c->words[v][i / SIDE * WORDS_A_ROW + i % SIDE / 32].covered >> i % SIDE % 32 &
                 1) == 0) {
                continue;
            }
            stp_fill_surface surface = c->surface[candidate++];
            double dx = i % SIDE + 0.5 - x, dy = i / SIDE + 0.5 - y;
            double dz = 100.0 * ((double)surface.nearness - nearness);
            double distance = dx * dx + dy * dy + dz * dz;
            bool facing = normal_part(surface.normal, 2) > 0.0f;
            if (facing && distance < 1.001) {
                best = distance < 0.999 ? 1 : best == 0 ? -1 : best;
            }
        }
    }
    return best;
}

void test_fill_keeps_uncovered_points(test_state* test)
{
    static fill_case made;
    make_case(&made, 1);
    static uint64_t pixels[PIXELS];
    memcpy(pixels, made.pixels, sizeof(pixels));
    stp_raster_target target = {SIDE, SIDE, SIDE, pixels};
    stp_fill_drop_portable(&made.query, 0, &target);
    uint32_t kept = 0, known = 0;
    for (uint32_t i = 0; i < PIXELS; i += 7) {
        if (made.pixels[i] != STP_RASTER_EMPTY) {
            int expected = expect_known(&made, i);
            bool dropped = pixels[i] == STP_RASTER_EMPTY;
            CHECK(expected < 0 || dropped == (expected == 1));
            CHECK(dropped || pixels[i] == made.pixels[i]);
            kept += !dropped;
            known += dropped;
        }
    }
    CHECK(kept > 50 && known > 50);
}

void test_fill_kernels_agree(test_state* test)
{
    if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
        static fill_case made;
        static uint64_t wide[PIXELS];
        for (uint64_t seed = 10; seed < 30; ++seed) {
            make_case(&made, seed);
            memcpy(wide, made.pixels, sizeof(wide));
            uint32_t width = SIDE - (uint32_t)(seed % 9);
            stp_raster_target one = {width, SIDE - 3, SIDE, made.pixels};
            stp_raster_target eight = {width, SIDE - 3, SIDE, wide};
            stp_fill_drop_portable(&made.query, 2, &one);
            STP_VECTOR(stp_fill_drop)(&made.query, 2, &eight);
            CHECK(memcmp(wide, made.pixels, sizeof(wide)) == 0);
        }
        return;
    }
    SKIP("this processor has one variant only");
}
