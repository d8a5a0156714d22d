// SPDX-License-Identifier: MIT
// Splats hidden by an occluder are skipped without a visible difference.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "raster/splats_kernel.h"

#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, SPLATS = 1000, BLOCK = 8, COLUMNS = WIDTH / BLOCK };
enum { ROWS = HEIGHT / BLOCK, WORDS = (SPLATS + 15) / 16, PIXELS = WIDTH * HEIGHT };

#define FOCAL 140.0f
#define NEAR 0.01f

typedef struct hidden_scene {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint64_t wall[PIXELS], pixels[PIXELS], expected[PIXELS];
    float blocks[COLUMNS * ROWS], windows[COLUMNS * ROWS];
    uint16_t hidden[WORDS];
    stp_raster_target target;
    stp_raster_splats splats;
    stp_raster_camera camera;
    stp_raster_occluder occluder;
} hidden_scene;

static double uniform(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53);
}

/// A wall of several depths that is already in the picture, with some parts missing.
static void make_wall(hidden_scene* s, uint64_t seed)
{
    for (uint32_t i = 0; i < COLUMNS * ROWS; ++i) {
        s->blocks[i] = FLT_MAX;
    }
    for (uint32_t y = 0; y < HEIGHT; ++y) {
        for (uint32_t x = 0; x < WIDTH; ++x) {
            uint64_t patch = x / 40 + 8 * (y / 40);
            double depth = uniform(seed, patch, 0.5, 2.0) + 0.001 * (double)x;
            bool missing = stp_rng_hash(seed + 9, patch) % 4 == 0;
            float nearness = missing ? 0.0f : NEAR / (float)depth;
            s->wall[y * WIDTH + x] =
                missing ? STP_RASTER_EMPTY : stp_raster_pixel(nearness, 100000);
            float* block = &s->blocks[(y / BLOCK) * COLUMNS + x / BLOCK];
            *block = nearness < *block ? nearness : *block;
        }
    }
    stp_raster_make_windows(s->blocks, COLUMNS, ROWS, s->windows);
}

/// Splats of one radius in a cube around and in front of the eye.
static void make_scene(hidden_scene* s, uint64_t seed, double radius)
{
    for (uint64_t i = 0; i < 3 * SPLATS; ++i) {
        s->positions[i] = (uint16_t)uniform(seed, i, 0, 65535);
    }
    for (uint64_t i = 0; i < SPLATS; ++i) {
        stp_vec3 n = {(float)uniform(seed + 1, 3 * i, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 1, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 2, -1, 1)};
        stp_octahedral_encode(n, s->normals + 2 * i);
    }
    s->target = (stp_raster_target){WIDTH, HEIGHT, WIDTH, s->pixels};
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .end = SPLATS,
                                    .step = 4.0f / 65536.0f,
                                    .origin = {-2.0f, -2.0f, -0.3f},
                                    .radius = (float)radius,
                                    .rim_depth = 4.0f,
                                    .back_depth = 2.0f};
    s->camera = (stp_raster_camera){.pixel_scale = FOCAL, .nearness_limit = 1.0f};
    const float rows[4][4] = {
        {FOCAL, 0, 0.5f * WIDTH, 0}, {0, FOCAL, 0.5f * HEIGHT, 0}, {0, 0, 0, NEAR}, {0, 0, 1, 0}};
    memcpy(s->camera.matrix.m, rows, sizeof(rows));
    for (int k = 0; k < 3; ++k) {
        s->camera.view[k][k] = 1.0f;
    }
    s->occluder = (stp_raster_occluder){.windows = s->windows,
                                        .columns = COLUMNS,
                                        .shift = 3,
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .pixel_scale = FOCAL,
                                        .scale = 1.0f,
                                        .corner = 1.3f,
                                        .near_distance = NEAR,
                                        .behind = 1.00001f};
    memcpy(s->occluder.matrix[0], rows[0], sizeof(rows[0]));
    memcpy(s->occluder.matrix[1], rows[1], sizeof(rows[1]));
    memcpy(s->occluder.matrix[2], rows[3], sizeof(rows[3]));
}

static uint64_t draw(hidden_scene* s, splat_kernel kernel)
{
    stp_splat_frame frame;
    bool any = stp_splats_make_frame(&frame, &s->target, 0, HEIGHT, &s->camera, &s->splats, 7);
    return any ? kernel(&frame) : 0;
}

static int count_bits(const uint16_t* bits)
{
    int count = 0;
    for (int i = 0; i < WORDS; ++i) {
        count += __builtin_popcount(bits[i]);
    }
    return count;
}

typedef bool (*ask_kernel)(const stp_splat_frame* frame, uint16_t* bits);

static void check_kernel(test_state* test, splat_kernel kernel, ask_kernel ask, int* hidden)
{
    static hidden_scene s;
    static uint16_t wanted[WORDS];
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        make_scene(&s, seed, 0.004 * (double)(seed % 4));
        make_wall(&s, seed);
        memcpy(s.pixels, s.wall, sizeof(s.wall));
        uint64_t whole = draw(&s, kernel);
        memcpy(s.expected, s.pixels, sizeof(s.pixels));
        // without the splats that the wall hides
        memcpy(s.pixels, s.wall, sizeof(s.wall));
        memset(s.hidden, 0xFF, sizeof(s.hidden));
        s.splats.occluder = &s.occluder;
        s.splats.hidden = s.hidden;
        uint64_t fewer = draw(&s, kernel);
        CHECK_EQUAL(0, memcmp(s.expected, s.pixels, sizeof(s.pixels)));
        int count = count_bits(s.hidden);
        CHECK(count < SPLATS && (count == 0 || fewer < whole));
        // drawn again, with the same occluder everything is hidden, with none nothing
        stp_splat_frame frame;
        memcpy(wanted, s.hidden, sizeof(wanted));
        stp_splats_test_frame(&frame, &s.splats);
        CHECK(!ask(&frame, wanted));
        CHECK_EQUAL(0, count_bits(wanted));
        memcpy(wanted, s.hidden, sizeof(wanted));
        memset(s.windows, 0, sizeof(s.windows));
        CHECK(ask(&frame, wanted) == (count > 0));
        // only the hidden ones, none of which is visible
        CHECK_EQUAL(0, memcmp(wanted, s.hidden, sizeof(wanted)));
        s.splats.occluder = NULL;
        s.splats.hidden = NULL;
        s.splats.wanted = wanted;
        uint64_t rest = draw(&s, kernel);
        CHECK_EQUAL(whole, fewer + rest);
        CHECK_EQUAL(0, memcmp(s.expected, s.pixels, sizeof(s.pixels)));
        *hidden += count;
    }
}

/// Draws the wanted splats in front of the wall with a kernel.
static void draw_wanted(hidden_scene* s, splat_kernel kernel, uint16_t hidden[WORDS])
{
    memcpy(s->pixels, s->wall, sizeof(s->wall));
    memset(s->hidden, 0xFF, sizeof(s->hidden));
    draw(s, kernel);
    memcpy(hidden, s->hidden, sizeof(s->hidden));
}

// Queued batches of sixteen give the same pixels and hidden splats as single words, for any number
// of wanted splats.
void test_splats_hidden_among_the_wanted(test_state* test)
{
    static hidden_scene s;
    static uint16_t wanted[WORDS], expected[WORDS], hidden[WORDS];
    const splat_kernel kernels[] = {STP_VECTOR(stp_splats_draw), STP_WIDE(stp_splats_draw)};
    stp_processor processor = stp_processor_detect();
    int count = 0;
    for (uint64_t seed = 1; seed <= 24; ++seed) {
        make_scene(&s, seed, 0.004 * (double)(seed % 4));
        make_wall(&s, seed);
        for (uint32_t i = 0; i < WORDS; ++i) { // from none to all
            uint64_t bits = UINT64_MAX;
            for (uint64_t k = 0; k < seed % 6; ++k) {
                bits &= stp_rng_hash(seed, 8 * (uint64_t)i + k);
            }
            wanted[i] = i % 7 == 3 ? 0xFFFF : i % 7 == 5 ? 0 : (uint16_t)bits;
        }
        s.splats.end = SPLATS - (uint32_t)(seed % 5);
        s.splats.wanted = wanted;
        s.splats.occluder = &s.occluder;
        s.splats.hidden = s.hidden;
        draw_wanted(&s, stp_splats_draw_portable, expected);
        memcpy(s.expected, s.pixels, sizeof(s.pixels));
        count += count_bits(expected);
        for (int k = 0; k < 2; ++k) {
            if (processor >= (k == 0 ? STP_PROCESSOR_VECTOR : STP_PROCESSOR_WIDE)) {
                draw_wanted(&s, kernels[k], hidden);
                CHECK_EQUAL(0, memcmp(s.expected, s.pixels, sizeof(s.pixels)));
                CHECK_EQUAL(0, memcmp(expected, hidden, sizeof(hidden)));
            }
        }
    }
    CHECK(count > 500);
}

void test_splats_hidden_cannot_be_seen(test_state* test)
{
    int hidden[3] = {0};
    check_kernel(test, stp_splats_draw_portable, stp_splats_test_portable, &hidden[0]);
    CHECK(hidden[0] > 500); // otherwise the test proves nothing
    stp_processor processor = stp_processor_detect();
    if (processor >= STP_PROCESSOR_VECTOR) {
        check_kernel(test, STP_VECTOR(stp_splats_draw), STP_VECTOR(stp_splats_test), &hidden[1]);
        CHECK_EQUAL(hidden[0], hidden[1]);
    }
    if (processor >= STP_PROCESSOR_WIDE) {
        check_kernel(test, STP_WIDE(stp_splats_draw), STP_WIDE(stp_splats_test), &hidden[2]);
        CHECK_EQUAL(hidden[0], hidden[2]);
    }
}
