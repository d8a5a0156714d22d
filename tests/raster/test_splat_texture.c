// SPDX-License-Identifier: MIT
// Opacity textures, and splats blended with them.
#include "support_blend.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "base/splats/octahedral.h"
#include "raster/splats_blend_kernel.h"

#include <string.h>

enum { WIDTH = 64, HEIGHT = 48, PIXELS = WIDTH * HEIGHT, SPLATS = 200 };
enum { SIDE = STP_SPLAT_TEXTURE_SIDE };

#define FOCAL 60.0f
#define NEAR 0.05f

typedef struct textured_scene {
    float points[3 * SPLATS];
    uint16_t positions[3 * SPLATS];
    int8_t normals[2 * SPLATS];
    uint32_t shapes[SPLATS];
    uint64_t pixels[PIXELS];
    stp_raster_plane planes[PIXELS];
    uint64_t sums[2 * PIXELS];
    stp_raster_camera camera;
    stp_raster_splats splats;
} textured_scene;

/// Ellipses in a slanted wall.
static void make_scene(textured_scene* s, uint64_t seed, float step_radius)
{
    *s = (textured_scene){.camera = {.pixel_scale = FOCAL, .nearness_limit = 1.0f}};
    for (uint32_t i = 0; i < SPLATS; ++i) {
        double across = blend_uniform(seed, 2 * i, -0.4, 0.4),
               down = blend_uniform(seed, 2 * i + 1, -0.3, 0.3);
        double depth = 1.0 + 0.5 * across;
        s->positions[3 * i] = (uint16_t)(32768.0 + 30000.0 * across);
        s->positions[3 * i + 1] = (uint16_t)(32768.0 + 30000.0 * down);
        s->positions[3 * i + 2] = (uint16_t)(30000.0 * depth);
        stp_octahedral_encode(
            (stp_vec3){0.45f, (float)blend_uniform(seed + 1, i, -0.2, 0.2), -0.9f},
            s->normals + 2 * (size_t)i);
        uint32_t larger = stp_shape_code(1.0f);
        uint32_t smaller = stp_shape_code((float)blend_uniform(seed + 2, i, 0.4, 1.0));
        s->shapes[i] = larger | smaller << 12 | (uint32_t)(stp_rng_hash(seed + 3, i) & 255) << 24;
    }
    const float rows[4][4] = {
        {FOCAL, 0, 0.5f * WIDTH, 0}, {0, FOCAL, 0.5f * HEIGHT, 0}, {0, 0, 0, NEAR}, {0, 0, 1, 0}};
    memcpy(s->camera.matrix.m, rows, sizeof(rows));
    for (int k = 0; k < 3; ++k) {
        s->camera.view[k][k] = 1.0f;
    }
    s->splats = (stp_raster_splats){.positions = s->positions,
                                    .normals = s->normals,
                                    .shapes = s->shapes,
                                    .end = SPLATS,
                                    .step = 1.0f / 30000.0f,
                                    .origin = {-32768.0f / 30000.0f, -32768.0f / 30000.0f, 0.0f},
                                    .radius = step_radius};
}

/// Draws splats and finds the plane of each pixel.
static stp_raster_blend begin(textured_scene* s, const stp_splat_texture* texture)
{
    stp_raster_target target = {WIDTH, HEIGHT, WIDTH, s->pixels};
    memset(s->pixels, 0xFF, sizeof(s->pixels));
    memset(s->sums, 0, sizeof(s->sums));
    stp_raster_draw_splats(&target, 0, HEIGHT, &s->camera, &s->splats, 0);
    for (int i = 0; i < PIXELS; ++i) {
        bool there = s->pixels[i] != STP_RASTER_EMPTY;
        uint32_t id = there ? stp_raster_id(s->pixels[i]) : UINT32_MAX;
        s->planes[i] = (stp_raster_plane){.id = id, .nearness = FLT_MAX};
    }
    stp_raster_blend blend = {.width = WIDTH,
                              .height = HEIGHT,
                              .planes = s->planes,
                              .sums = (_Atomic uint64_t*)s->sums,
                              .colors = blend_color_splats,
                              .texture = texture};
    stp_raster_find_planes(&blend, &s->camera, &s->splats);
    return blend;
}

static uint32_t weight_at(const textured_scene* s, int at)
{
    return (uint32_t)(s->sums[2 * at + 1] >> 32);
}

// All splats of a pixel count equally: the sum is the number of splats that cover it, each drawn
// alone.
void test_splat_texture_constant_gives_equal_weights(test_state* test)
{
    static textured_scene s;
    static uint32_t counts[PIXELS], colors[3 * PIXELS];
    stp_splat_texture opaque;
    memset(opaque.texels, 255, sizeof(opaque.texels));
    for (uint64_t seed = 0; seed < 4; ++seed) {
        make_scene(&s, 10 * seed, seed == 0 ? 0.004f : 0.02f * (float)seed);
        stp_raster_blend blend = begin(&s, NULL);
        memset(counts, 0, sizeof(counts));
        memset(colors, 0, sizeof(colors));
        for (uint32_t i = 0; i < SPLATS; ++i) { // with the other weights, which are never 0
            uint32_t color[1][3];
            memset(s.sums, 0, sizeof(s.sums));
            s.splats.begin = i;
            s.splats.end = i + 1;
            stp_raster_blend_splats(&blend, &s.camera, &s.splats);
            blend_color_splats(NULL, i, 1, NULL, NULL, color);
            for (int at = 0; at < PIXELS; ++at) {
                bool there = weight_at(&s, at) > 0;
                counts[at] += there;
                for (int k = 0; k < 3; ++k) {
                    colors[3 * at + k] += there ? color[0][k] : 0;
                }
            }
        }
        s.splats.begin = 0;
        s.splats.end = SPLATS;
        blend = begin(&s, &opaque);
        stp_raster_blend_splats(&blend, &s.camera, &s.splats);
        int wrong = 0, several = 0;
        for (int at = 0; at < PIXELS; ++at) {
            uint32_t red = (uint32_t)s.sums[2 * at], blue = (uint32_t)s.sums[2 * at + 1];
            wrong += weight_at(&s, at) != STP_BLEND_WEIGHT * counts[at];
            wrong += red != STP_BLEND_WEIGHT * colors[3 * at];
            wrong += blue != STP_BLEND_WEIGHT * colors[3 * at + 2];
            several += counts[at] > 1;
        }
        CHECK_EQUAL(0, wrong);
        CHECK(several > (seed == 0 ? 5 : 50));
    }
}

/// Position along the larger or smaller axis of splat `index`, -1 to 1, where the ray through a
/// pixel meets its plane; in double precision.
static double find_place(const textured_scene* s, uint32_t index, bool smaller, double x, double y)
{
    const int8_t* code = s->normals + 2 * (size_t)index;
    stp_vec3 n = stp_octahedral_unfold((float)code[0], (float)code[1]);
    stp_disk_axes axes = stp_disk_axes_of((float)code[0], (float)code[1]);
    uint32_t shape = s->shapes[index], larger = shape & 0xFFFu, less = shape >> 12 & 0xFFFu;
    double turn = larger != less ? STP_PI * (double)(shape >> 24) / 256.0 : 0.0; // disks have none
    double c = smaller ? -sin(turn) : cos(turn), d = smaller ? cos(turn) : sin(turn);
    double along[3] = {c * (double)axes.x.x + d * (double)axes.y.x,
                       c * (double)axes.x.y + d * (double)axes.y.y,
                       c * (double)axes.x.z + d * (double)axes.y.z};
    double normal[3] = {(double)n.x, (double)n.y, (double)n.z}, center[3], above = 0.0, slope = 0.0;
    double ray[3] = {(x - 0.5 * WIDTH) / (double)FOCAL, (y - 0.5 * HEIGHT) / (double)FOCAL, 1.0};
    for (uint32_t k = 0; k < 3; ++k) {
        center[k] = ((double)s->positions[3 * index + k] - (k < 2 ? 32768.0 : 0.0)) / 30000.0;
        above += normal[k] * center[k];
        slope += normal[k] * ray[k];
    }
    double place = 0.0;
    for (int k = 0; k < 3; ++k) {
        place += along[k] * (above / slope * ray[k] - center[k]);
    }
    return place / ((double)s->splats.radius * (double)stp_shape_radius(smaller ? less : larger));
}

// A ramp along each axis matches the ray computation, on near splats in perspective; its direction
// is either.
void test_splat_texture_lies_in_the_plane(test_state* test)
{
    static textured_scene s;
    stp_splat_texture ramps[2];
    for (int i = 0; i < SIDE * SIDE; ++i) {
        ramps[0].texels[i] = (uint8_t)(8 * (i % SIDE));
        ramps[1].texels[i] = (uint8_t)(8 * (i / SIDE));
    }
    int wrong = 0, seen = 0;
    for (uint32_t i = 0; i < SPLATS; i += 5) {
        bool smaller = i % 2 == 1;
        make_scene(&s, 50, 0.16f);
        s.splats.begin = i;
        s.splats.end = i + 1;
        stp_raster_blend blend = begin(&s, &ramps[smaller]);
        stp_raster_blend_splats(&blend, &s.camera, &s.splats);
        int off[2] = {0, 0};
        for (int at = 0; at < PIXELS; ++at) {
            if (weight_at(&s, at) == 0) {
                continue;
            }
            double place = find_place(&s, i, smaller, at % WIDTH + 0.5, at / WIDTH + 0.5);
            for (int side = 0; side < 2; ++side) {
                double ours = side == 0 ? place : -place;
                double texel = fmin(fmax((0.5 * ours + 0.5) * SIDE - 0.5, 0.0), SIDE - 1.0);
                double weight = 1.0 + (STP_BLEND_WEIGHT - 1) * 8.0 * texel / 255.0;
                off[side] += fabs(floor(weight) - (double)weight_at(&s, at)) > 1.0;
            }
            seen += 1;
        }
        wrong += off[0] < off[1] ? off[0] : off[1];
    }
    CHECK_EQUAL(0, wrong);
    CHECK(seen > 2000);
}

void test_splat_texture_blends_alike_by_all_variants(test_state* test)
{
    static textured_scene s;
    static uint64_t sums[2 * PIXELS];
    const stp_splat_texture gaussian = stp_splat_texture_gaussian();
    for (uint64_t seed = 0; seed < 4; ++seed) {
        make_scene(&s, seed, 0.01f * (float)(1 + 3 * seed));
        s.splats.shapes = seed % 2 == 0 ? s.shapes : NULL;
        stp_raster_blend blend = begin(&s, &gaussian);
        stp_splats_blend_portable(&blend, &s.camera, &s.splats, true);
        memcpy(sums, s.sums, sizeof(sums));
        if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
            memset(s.sums, 0, sizeof(s.sums));
            STP_VECTOR(stp_splats_blend)(&blend, &s.camera, &s.splats, true);
            CHECK_EQUAL(0, memcmp(sums, s.sums, sizeof(sums)));
        }
        if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
            memset(s.sums, 0, sizeof(s.sums));
            STP_WIDE(stp_splats_blend)(&blend, &s.camera, &s.splats, true);
            CHECK_EQUAL(0, memcmp(sums, s.sums, sizeof(sums)));
        }
    }
}

// Points face the eye, and have no axes.
void test_splat_texture_of_points_is_round(test_state* test)
{
    static textured_scene s;
    const stp_splat_texture gaussian = stp_splat_texture_gaussian();
    make_scene(&s, 3, 0.2f);
    s.points[2] = 1.0f;
    s.splats.points = s.points;
    s.splats.positions = NULL;
    s.splats.normals = NULL;
    s.splats.shapes = NULL;
    s.splats.end = 1;
    stp_raster_blend blend = begin(&s, &gaussian);
    stp_raster_blend_splats(&blend, &s.camera, &s.splats);
    int middle = (HEIGHT / 2) * WIDTH + WIDTH / 2;
    CHECK(weight_at(&s, middle) >= 60 && weight_at(&s, middle + 8) < weight_at(&s, middle));
    CHECK_EQUAL(weight_at(&s, middle + 8), weight_at(&s, middle + 8 * WIDTH));
}

void test_splat_texture_is_averaged_from_images(test_state* test)
{
    static uint8_t pixels[4 * 80 * 50];
    stp_image image = {80, 50, pixels};
    for (int i = 0; i < 80 * 50; ++i) { // grey on the left half, white on the right
        memset(pixels + 4 * i, i % 80 < 40 ? 100 : 255, 3);
        pixels[4 * i + 3] = 255;
    }
    stp_splat_texture grey = stp_splat_texture_of_image(&image);
    pixels[3] = 0; // some of it is transparent now, so colours do not count
    stp_splat_texture alpha = stp_splat_texture_of_image(&image);
    int wrong = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        wrong += grey.texels[i] != (i % SIDE < SIDE / 2 ? 100 : 255);
        wrong += (alpha.texels[i] != 255) != (i == 0);
    }
    CHECK_EQUAL(0, wrong);
    CHECK(alpha.texels[0] > 100 && alpha.texels[0] < 255);
    stp_image small = {2, 1, pixels + 4}; // texels larger than pixels
    pixels[7] = 40;
    stp_splat_texture two = stp_splat_texture_of_image(&small);
    CHECK_EQUAL(40, two.texels[0]);
    CHECK_EQUAL(40, two.texels[SIDE * SIDE - SIDE + SIDE / 2 - 1]);
    CHECK_EQUAL(255, two.texels[SIDE / 2]);
    memset(grey.texels, 255, sizeof(grey.texels));
    CHECK(stp_splat_texture_mean(&grey) == 1.0f);
    CHECK(stp_splat_texture_read(&grey, 0.3f, NAN) == 1.0f);
}
