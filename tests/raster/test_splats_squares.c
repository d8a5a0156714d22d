// SPDX-License-Identifier: MIT
// Square splats: every pixel whose centre lies in the square, at the nearness of the splat's centre.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "raster/splats_squares_kernel.h"

#include <string.h>

enum { WIDTH = 96, HEIGHT = 72, PIXELS = WIDTH * HEIGHT, SPLATS = 400 };

#define FOCAL 80.0
#define NEAR 0.05

typedef struct square_scene {
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint8_t coverages[SPLATS];
    uint32_t shapes[SPLATS];
    uint64_t pixels[PIXELS];
    stp_raster_target target;
    stp_raster_splats splats;
    stp_raster_camera camera;
} square_scene;

static double uniform(uint64_t seed, uint64_t index, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(seed, index) >> 11) * 0x1p-53);
}

/// Splats in the unit cube, which begins at depth `distance`.
static void make_scene(square_scene* s, uint64_t seed, double radius, double distance,
                       bool parallel)
{
    *s = (square_scene){.target = {WIDTH, HEIGHT, WIDTH, s->pixels}};
    for (uint32_t i = 0; i < SPLATS; ++i) {
        for (uint32_t k = 0; k < 3; ++k) {
            s->positions[3 * i + k] = (uint16_t)uniform(seed, 3 * i + k, 0, 65535);
        }
        stp_vec3 n = {(float)uniform(seed + 1, 3 * i, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 1, -1, 1),
                      (float)uniform(seed + 1, 3 * i + 2, -1, 1)};
        stp_octahedral_encode(n, s->normals + 2 * (size_t)i);
        s->coverages[i] = (uint8_t)stp_rng_hash(seed + 2, i);
        uint32_t larger = stp_shape_code((float)uniform(seed + 3, i, 0.4, 2.0));
        s->shapes[i] = larger | (larger - (uint32_t)(stp_rng_hash(seed + 4, i) % 200)) << 12;
    }
    double s_px = parallel ? 60.0 : FOCAL, middle = parallel ? 0.0 : 1.0;
    const double rows[4][4] = {{s_px, 0, 0.5 * WIDTH * middle, -0.5 * s_px},
                               {0, s_px, 0.5 * HEIGHT * middle, -0.5 * s_px},
                               {0, 0, parallel ? -NEAR : 0.0, parallel ? 0.9 : NEAR},
                               {0, 0, middle, 1.0 - middle}};
    for (int r = 0; r < 4; ++r) { // view z is the position's z and the distance
        for (int k = 0; k < 4; ++k) {
            double shifted = k == 3 ? rows[r][3] + rows[r][2] * distance : rows[r][k];
            s->camera.matrix.m[r][k] = (float)shifted;
        }
        if (parallel && r < 2) {
            s->camera.matrix.m[r][3] = (float)(0.5 * (r == 0 ? WIDTH : HEIGHT) - 0.5 * s_px);
        }
    }
    for (int r = 0; r < 3; ++r) {
        s->camera.view[r][r] = 1.0f;
        s->camera.view[r][3] = (float)(r == 2 ? distance : -0.5);
    }
    s->camera.pixel_scale = (float)s_px;
    s->camera.parallel = parallel;
    s->camera.nearness_limit = 1.0f;
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .end = SPLATS,
                                    .step = 1.0f / 65536.0f,
                                    .radius = (float)radius,
                                    .squares = true};
}

static void clear(square_scene* s)
{
    memset(s->pixels, 0xFF, sizeof(s->pixels));
}

typedef struct square {
    double x, y, radius, nearness; ///< in pixels
    double away;                   ///< loss of nearness if the disk faces away
} square;

static square find_square(const square_scene* s, uint32_t index)
{
    double p[3], rows[4], own = 1.0;
    for (uint32_t k = 0; k < 3; ++k) {
        p[k] = (double)s->positions[3 * index + k] / 65536.0;
    }
    for (int r = 0; r < 4; ++r) {
        const float* m = s->camera.matrix.m[r];
        rows[r] = (double)m[0] * p[0] + (double)m[1] * p[1] + (double)m[2] * p[2] + (double)m[3];
    }
    if (s->splats.shapes != NULL) {
        own = (double)stp_shape_radius(s->shapes[index] & 0xFFFu);
    }
    double scale = (double)s->camera.pixel_scale, radius = (double)s->splats.radius * own;
    square q = {.x = rows[0] / rows[3],
                .y = rows[1] / rows[3],
                .radius = radius * scale / rows[3],
                .nearness = rows[2] / rows[3]};
    stp_vec3 n = stp_octahedral_decode(s->normals[2 * index], s->normals[2 * index + 1]);
    double towards = s->camera.parallel ? (double)n.z
                                        : (double)n.x * (p[0] - 0.5) + (double)n.y * (p[1] - 0.5) +
                                              (double)n.z * rows[3];
    double step = s->camera.parallel ? NEAR * radius : q.nearness * radius / rows[3];
    q.away = towards > 0.0 ? (double)s->splats.back_depth * step : 0.0;
    return rows[3] > 0.0 && q.nearness <= 1.0 ? q : (square){.radius = -1.0};
}

/// Wrong pixels of one splat drawn alone.
static int count_wrong(square_scene* s, uint32_t index, int* drawn)
{
    clear(s);
    s->splats.begin = index;
    s->splats.end = index + 1;
    uint64_t fragments = stp_raster_draw_splats(&s->target, 0, HEIGHT, &s->camera, &s->splats, 7),
             counted = 0;
    square q = find_square(s, index);
    int wrong = 0;
    for (int at = 0; at < PIXELS; ++at) {
        double x = at % WIDTH + 0.5, y = at / WIDTH + 0.5;
        double aside = fmax(fabs(x - q.x), fabs(y - q.y));
        bool own = q.radius > 0.0 && floor(q.x) == floor(x) && floor(q.y) == floor(y);
        bool expected = aside <= q.radius || own;
        bool close = fabs(fabs(x - q.x) - q.radius) < 1e-3 || fabs(fabs(y - q.y) - q.radius) < 1e-3;
        close = close || fabs(q.x - round(q.x)) < 1e-3 || fabs(q.y - round(q.y)) < 1e-3;
        bool got = s->pixels[at] != STP_RASTER_EMPTY;
        counted += got;
        wrong += got != expected && !close;
        if (got) {
            double nearness = (double)stp_raster_nearness(s->pixels[at]);
            double lost = q.radius > 0.6 ? q.away : 0.0; // a single pixel has no back
            double wanted = fmax(q.nearness - lost, 0.0);
            bool vague = fabs(q.radius - 0.55) < 0.1;
            wrong += stp_raster_id(s->pixels[at]) != 7 + index;
            wrong += !vague && fabs(nearness - wanted) > 1e-5 + 1e-4 * q.nearness;
        }
    }
    *drawn += counted > 0;
    return wrong + (fragments != counted);
}

void test_splats_squares_cover_the_pixels_of_their_boxes(test_state* test)
{
    static square_scene s;
    const double radii[] = {0.002, 0.008, 0.03, 0.1, 0.6, 9.0};
    for (int round = 0; round < 24; ++round) {
        bool parallel = round % 2 == 1;
        make_scene(&s, 10 + (uint64_t)round, radii[round / 4], round % 4 == 2 ? -0.2 : 1.5,
                   parallel); // -0.2: some are behind the eye
        s.splats.shapes = round % 3 == 0 ? s.shapes : NULL;
        s.splats.back_depth = round % 3 == 1 ? 0.3f : 0.0f;
        int wrong = 0, drawn = 0;
        for (uint32_t i = (uint32_t)round; i < SPLATS; i += 9) {
            wrong += count_wrong(&s, i, &drawn);
        }
        CHECK_EQUAL(0, wrong);
        CHECK(drawn > 5);
    }
}

static uint64_t hash_pixels(const square_scene* s)
{
    uint64_t hash = 0;
    for (int i = 0; i < PIXELS; ++i) {
        hash = stp_rng_hash(hash, s->pixels[i]);
    }
    return hash;
}

static uint64_t draw_variant(square_scene* s, splat_kernel kernel, uint64_t* fragments)
{
    stp_splat_frame frame;
    clear(s);
    bool made = stp_splats_make_frame(&frame, &s->target, 0, HEIGHT, &s->camera, &s->splats, 0);
    *fragments = made ? kernel(&frame) : 0;
    return hash_pixels(s);
}

/// With shares, clips and individual radii, by each variant, and in bands of rows as at once.
void test_splats_squares_are_the_same_by_all_variants(test_state* test)
{
    static square_scene s;
    for (int round = 0; round < 12; ++round) {
        uint64_t fragments, other;
        make_scene(&s, 60 + (uint64_t)round, 0.005 * (1 << round / 2), 0.5, round % 3 == 2);
        s.splats.coverages = s.coverages;
        s.splats.shapes = round % 2 == 0 ? s.shapes : NULL;
        s.splats.back_depth = 2.0f;
        uint64_t hash = draw_variant(&s, stp_splats_squares_portable, &fragments);
        CHECK(fragments > 100);
        if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
            CHECK(draw_variant(&s, STP_VECTOR(stp_splats_squares), &other) == hash);
            CHECK_EQUAL(fragments, other);
        }
        if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
            CHECK(draw_variant(&s, STP_WIDE(stp_splats_squares), &other) == hash);
            CHECK_EQUAL(fragments, other);
        }
        clear(&s);
        other = stp_raster_draw_splats(&s.target, 0, 13, &s.camera, &s.splats, 0);
        other += stp_raster_draw_splats(&s.target, 13, HEIGHT, &s.camera, &s.splats, 0);
        CHECK(hash_pixels(&s) == hash);
        CHECK_EQUAL(fragments, other);
    }
}

// A share makes holes in squares, a clip removes pixels on one side; whole squares have more
// pixels.
void test_splats_squares_have_the_holes_and_cuts_of_disks(test_state* test)
{
    static square_scene s;
    int holes = 0, cuts = 0;
    for (uint32_t i = 0; i < 60; ++i) {
        make_scene(&s, 90, 0.1, 1.5, false);
        s.splats.begin = i;
        s.splats.end = i + 1;
        clear(&s);
        uint64_t whole = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0),
                 part, cut;
        s.splats.coverages = s.coverages;
        s.coverages[i] = stp_coverage_of_share(0.6);
        clear(&s);
        part = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
        s.coverages[i] = (uint8_t)(STP_COVERAGE_HALVES + i % 72);
        clear(&s);
        cut = stp_raster_draw_splats(&s.target, 0, HEIGHT, &s.camera, &s.splats, 0);
        CHECK(part <= whole && cut <= whole);
        holes += part * 10 > whole * 4 && part * 10 < whole * 8;
        cuts += cut * 10 > whole * 3 && cut * 100 < whole * 98;
    }
    CHECK(holes > 40 && cuts > 40);
}
