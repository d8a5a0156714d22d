// SPDX-License-Identifier: MIT
// The splat filter: all variants find the same planes and sums, and splats hidden by an occluder of
// the planes add nothing.
#include "support_blend.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "raster/splats_blend_kernel.h"

#include <string.h>

enum { WIDTH = 96, HEIGHT = 64, PIXELS = WIDTH * HEIGHT, SPLATS = 3000, WORDS = SPLATS / 16 + 1 };
enum { BLOCK = 8, COLUMNS = WIDTH / BLOCK, ROWS = HEIGHT / BLOCK };

#define FOCAL 80.0f
#define NEAR 0.01f

typedef struct blend_scene {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint8_t coverages[SPLATS];
    uint16_t visible[WORDS];
    uint64_t pixels[PIXELS];
    stp_raster_plane planes[PIXELS];
    uint64_t sums[2 * PIXELS];
    float blocks[COLUMNS * ROWS], windows[COLUMNS * ROWS];
    stp_raster_camera camera;
    stp_raster_splats splats;
    stp_raster_occluder occluder;
} blend_scene;

/// Two bumpy walls, one behind the other, with gaps.
static void make_scene(blend_scene* s, uint64_t seed)
{
    *s = (blend_scene){.camera = {.pixel_scale = FOCAL, .nearness_limit = 1.0f}};
    for (uint32_t i = 0; i < SPLATS; ++i) {
        double depth = i % 6 != 0 ? 0.5 : 0.6;
        double across = blend_uniform(seed, 4 * i, -1, 1),
               down = blend_uniform(seed, 4 * i + 1, -1, 1);
        depth += 0.02 * blend_uniform(seed, 4 * i + 2, 0, 1) + 0.1 * across;
        s->positions[3 * i] = (uint16_t)(32768.0 + 30000.0 * across * 0.4);
        s->positions[3 * i + 1] = (uint16_t)(32768.0 + 30000.0 * down * 0.4);
        s->positions[3 * i + 2] = (uint16_t)(depth * 30000.0);
        stp_vec3 n = {(float)blend_uniform(seed + 1, 3 * i, -0.7, 0.7),
                      (float)blend_uniform(seed + 1, 3 * i + 1, -0.7, 0.7), -1.0f};
        stp_octahedral_encode(n, s->normals + 2 * (size_t)i);
        s->coverages[i] = i % 5 == 0 ? 120 : 255;
    }
    const float rows[4][4] = {
        {FOCAL, 0, 0.5f * WIDTH, 0}, {0, FOCAL, 0.5f * HEIGHT, 0}, {0, 0, 0, NEAR}, {0, 0, 1, 0}};
    memcpy(s->camera.matrix.m, rows, sizeof(rows));
    for (int k = 0; k < 3; ++k) {
        s->camera.view[k][k] = 1.0f;
    }
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .coverages = s->coverages,
                                    .end = SPLATS,
                                    .step = 1.0f / 30000.0f,
                                    .origin = {-32768.0f / 30000.0f, -32768.0f / 30000.0f, 0.0f},
                                    .radius = 0.006f * (float)(1 + seed % 4),
                                    .rim_depth = 4.0f,
                                    .back_depth = 2.0f};
    s->occluder = (stp_raster_occluder){.windows = s->windows,
                                        .columns = COLUMNS,
                                        .shift = 3,
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .pixel_scale = FOCAL,
                                        .scale = 1.0f,
                                        .corner = 1.3f,
                                        .near_distance = NEAR,
                                        .behind = 1.00001f,
                                        .apart = STP_BLEND_AWAY};
    memcpy(s->occluder.matrix[0], rows[0], sizeof(rows[0]));
    memcpy(s->occluder.matrix[1], rows[1], sizeof(rows[1]));
    memcpy(s->occluder.matrix[2], rows[3], sizeof(rows[3]));
}

/// Draws, and records which splats are visible.
static void draw(blend_scene* s)
{
    stp_raster_target target = {WIDTH, HEIGHT, WIDTH, s->pixels};
    memset(s->pixels, 0xFF, sizeof(s->pixels));
    stp_raster_draw_splats(&target, 0, HEIGHT, &s->camera, &s->splats, 7);
    for (int i = 0; i < PIXELS; ++i) {
        bool there = s->pixels[i] != STP_RASTER_EMPTY;
        uint32_t id = there ? stp_raster_id(s->pixels[i]) : UINT32_MAX;
        s->planes[i] = (stp_raster_plane){.id = id, .nearness = FLT_MAX};
        if (there) {
            s->visible[(id - 7) / 16] |= (uint16_t)(1u << (id - 7) % 16);
        }
    }
}

static stp_raster_blend filter(blend_scene* s)
{
    memset(s->sums, 0, sizeof(s->sums));
    return (stp_raster_blend){.width = WIDTH,
                              .height = HEIGHT,
                              .planes = s->planes,
                              .first_id = 7,
                              .sums = (_Atomic uint64_t*)s->sums,
                              .colors = blend_color_splats};
}

static void make_windows(blend_scene* s)
{
    for (int i = 0; i < COLUMNS * ROWS; ++i) {
        s->blocks[i] = FLT_MAX;
    }
    for (int i = 0; i < PIXELS; ++i) {
        float* block = &s->blocks[i / WIDTH / BLOCK * COLUMNS + i % WIDTH / BLOCK];
        *block = s->planes[i].nearness < *block ? s->planes[i].nearness : *block;
    }
    stp_raster_make_windows(s->blocks, COLUMNS, ROWS, s->windows);
}

static void check_kernel(test_state* test, blend_kernel kernel, uint64_t* hash)
{
    static blend_scene s;
    static stp_raster_plane planes[PIXELS];
    static uint64_t sums[2 * PIXELS];
    *hash = 0;
    for (uint64_t seed = 0; seed < 8; ++seed) {
        make_scene(&s, seed);
        draw(&s);
        stp_raster_blend blend = filter(&s);
        memcpy(planes, s.planes, sizeof(planes));
        kernel(&blend, &s.camera, &s.splats, false);
        for (int i = 0; i < PIXELS; ++i) { // visible splats have the planes of all splats
            stp_raster_plane all = s.planes[i];
            s.planes[i] = planes[i];
            planes[i] = all;
        }
        s.splats.wanted = s.visible;
        kernel(&blend, &s.camera, &s.splats, false);
        CHECK_EQUAL(0, memcmp(planes, s.planes, sizeof(planes)));
        s.splats.wanted = NULL;
        kernel(&blend, &s.camera, &s.splats, true);
        memcpy(sums, s.sums, sizeof(sums));
        make_windows(&s);
        blend = filter(&s);
        s.splats.occluder = &s.occluder;
        kernel(&blend, &s.camera, &s.splats, true);
        CHECK_EQUAL(0, memcmp(sums, s.sums, sizeof(sums)));
        for (int i = 0; i < 2 * PIXELS; ++i) {
            *hash = stp_rng_hash(*hash, sums[i]);
        }
    }
}

void test_splats_blend_alike_whatever_is_left_out(test_state* test)
{
    static blend_scene s;
    uint64_t portable, other;
    check_kernel(test, stp_splats_blend_portable, &portable);
    stp_processor processor = stp_processor_detect();
    if (processor >= STP_PROCESSOR_VECTOR) {
        check_kernel(test, STP_VECTOR(stp_splats_blend), &other);
        CHECK(portable == other);
    }
    if (processor >= STP_PROCESSOR_WIDE) {
        check_kernel(test, STP_WIDE(stp_splats_blend), &other);
        CHECK(portable == other);
    }
    // many are hidden, or nothing was tested
    make_scene(&s, 3);
    draw(&s);
    stp_raster_blend blend = filter(&s);
    stp_splats_blend_portable(&blend, &s.camera, &s.splats, false);
    make_windows(&s);
    s.splats.occluder = &s.occluder;
    uint16_t bits[WORDS];
    int left = 0;
    memset(bits, 0xFF, sizeof(bits));
    stp_raster_test_splats(&s.splats, bits);
    for (int i = 0; i < SPLATS; ++i) {
        left += bits[i / 16] >> i % 16 & 1;
    }
    CHECK(left > 2000 && left < 2900);
    int ends = 0;
    for (uint32_t end = 8; end + 8 <= SPLATS; end += 16) { // splats beyond the end are left alone
        if (bits[end / 16] >> 8 == 0xFF) {
            continue;
        }
        uint16_t some[WORDS];
        memset(some, 0xFF, sizeof(some));
        s.splats.end = end;
        stp_raster_test_splats(&s.splats, some);
        CHECK_EQUAL(0xFF, some[end / 16] >> 8);
        ends += 1;
    }
    CHECK(ends > 0);
}
