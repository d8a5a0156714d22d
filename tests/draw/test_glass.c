// SPDX-License-Identifier: MIT
// Transparent surfaces: layers without noise, and a stable pattern.
#include "support_gl.h"
#include "tests.h"

#include "base/math/color.h"
#include "base/splats/coverage.h"
#include "program/measure/image_compare.h"

#include <math.h>
#include <string.h>

enum { SIDE = PICTURE_SIDE, PIXELS = SIDE * SIDE, BYTES = PIXELS * 4, CHECKS = 6 };

/// A chequered wall behind two sheets of glass, the front one rotated.
static void add_scene(made_picture* p, bool splats)
{
    static const float dark[4] = {0.05f, 0.06f, 0.1f, 1.0f}, green[4] = {0.1f, 0.7f, 0.3f, 0.35f};
    static const float red[4] = {0.8f, 0.2f, 0.1f, 0.6f};
    made_picture_add_material(p, 1, dark);
    made_picture_add_material(p, 2, green);
    made_picture_add_material(p, 3, red);
    for (int i = 0; i < CHECKS; ++i) { // the wall itself is white
        double x = -1.25 + 1.25 * (i % 3), y = i < 3 ? -1.25 : 1.25;
        made_picture_add_sheet(p, (uint32_t)i % 2, 0.0, (stp_vec3d){x, y, -2.0 - 0.01 * i}, false);
    }
    made_picture_add_sheet(p, 2, 0.0, (stp_vec3d){-0.3, 0.1, 0.0}, splats);
    made_picture_add_sheet(p, 3, 0.4, (stp_vec3d){0.3, -0.2, 1.0}, splats);
    p->quality.splat_size = 6;
}

static void add_triangles(made_picture* p)
{
    add_scene(p, false);
}

static void add_splats(made_picture* p)
{
    add_scene(p, true);
}

static double find_psnr(stp_context* context, uint8_t* a, uint8_t* b)
{
    stp_image left = {SIDE, SIDE, a}, right = {SIDE, SIDE, b};
    stp_image_quality quality;
    return stp_image_compare(context, &left, &right, NULL, NULL, &quality) == STP_OK ? quality.psnr
                                                                                     : 0.0;
}

static void begin(test_state* test, made_picture* p, uint32_t threads, void (*add)(made_picture*))
{
    CHECK(made_picture_begin(p, NULL, threads));
    add(p);
    CHECK_EQUAL(STP_OK, made_picture_open(p));
}

void test_glass_layers_match_many_samples(test_state* test)
{
    for (int splats = 0; splats < 2; ++splats) {
        static uint8_t layers[BYTES], pattern[BYTES];
        made_picture p;
        begin(test, &p, 2, splats ? add_splats : add_triangles);
        p.style.supersample = 8;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK((p.stats.splats > 0) == (splats != 0));
        CHECK_EQUAL(2, p.stats.layers);
        memcpy(layers, p.pixels, BYTES);
        p.style.transparency = STP_TRANSPARENCY_PATTERN;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        memcpy(pattern, p.pixels, BYTES);
        p.style.supersample = 32;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(find_psnr(p.context, layers, p.pixels) >= 40.0);
        CHECK(find_psnr(p.context, pattern, p.pixels) < find_psnr(p.context, layers, p.pixels));
        made_picture_end(&p);
    }
}

void test_glass_of_splats_is_as_opaque_as_of_triangles(test_state* test)
{
    for (int style = 0; style < 2; ++style) {
        double sums[2][3] = {{0}};
        for (int splats = 0; splats < 2; ++splats) {
            made_picture p;
            begin(test, &p, 1, splats ? add_splats : add_triangles);
            p.style.transparency = (stp_transparency)style;
            p.style.supersample = 4;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            for (int i = 0; i < 12 * 12; ++i) { // within both sheets
                const uint8_t* pixel = made_picture_pixel(&p, 25 + i % 12, 26 + i / 12);
                for (int c = 0; c < 3; ++c) {
                    sums[splats][c] += (double)stp_srgb8_to_linear(pixel[c]) / (12.0 * 12.0);
                }
            }
            made_picture_end(&p);
        }
        for (int c = 0; c < 3; ++c) {
            CHECK(fabs(sums[0][c] - sums[1][c]) < 0.02);
        }
    }
}

void test_glass_does_not_depend_on_threads(test_state* test)
{
    for (int kind = 0; kind < 4; ++kind) {
        static uint8_t first[BYTES];
        for (uint32_t threads = 1; threads < 8; threads += 2) {
            made_picture p;
            begin(test, &p, threads, kind & 1 ? add_splats : add_triangles);
            p.style.transparency = kind & 2 ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_LAYERS;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            if (threads == 1) {
                memcpy(first, p.pixels, BYTES);
            }
            CHECK(memcmp(first, p.pixels, BYTES) == 0);
            made_picture_end(&p);
        }
    }
}

static int over(float front, float alpha, float back)
{
    return stp_linear_to_srgb8(alpha * front + (1.0f - alpha) * back);
}

void test_glass_layers_are_composited_front_to_back(test_state* test)
{
    static const float red[4] = {0.9f, 0.1f, 0.1f, 0.5f}, blue[4] = {0.1f, 0.1f, 0.9f, 0.25f};
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    made_picture_add_material(&p, 1, red);
    made_picture_add_material(&p, 2, blue);
    made_picture_add_sheet(&p, 0, 0.0, (stp_vec3d){0, 0, -1.0}, false); // white
    made_picture_add_sheet(&p, 1, 0.5, (stp_vec3d){0, 0, 0}, false);    // they intersect
    made_picture_add_sheet(&p, 2, -0.5, (stp_vec3d){0, 0, 0}, false);
    made_picture_add_sheet(&p, 0, 0.0, (stp_vec3d){0, -9.0, 0.5}, false); // out of sight
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    for (int half = 0; half < 2; ++half) {
        const uint8_t* pixel = made_picture_pixel(&p, SIDE / 2, half == 0 ? 24 : 40);
        const float* front = half == 0 ? red : blue;
        const float* back = half == 0 ? blue : red;
        for (int c = 0; c < 3; ++c) {
            float behind = back[3] * back[c] + (1.0f - back[3]);
            CHECK(abs(pixel[c] - over(front[c], front[3], behind)) <= 1);
        }
        CHECK_EQUAL(255, pixel[3]);
    }
    made_picture_end(&p);
}

void test_glass_before_nothing_is_transparent_in_the_picture(test_state* test)
{
    static const float red[4] = {0.9f, 0.1f, 0.1f, 0.5f};
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    made_picture_add_material(&p, 1, red);
    made_picture_add_sheet(&p, 1, 0.0, (stp_vec3d){0, 0, 0}, false);
    made_picture_add_sheet(&p, 1, 0.0, (stp_vec3d){0, 0, -0.5}, false);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    for (int accumulated = 0; accumulated < 2; ++accumulated) {
        for (int i = 0; i < 4; ++i) {
            CHECK_EQUAL(STP_OK, accumulated ? made_picture_accumulate(&p) : made_picture_draw(&p));
        }
        const uint8_t* pixel = made_picture_pixel(&p, SIDE / 2, SIDE / 2);
        CHECK(abs(pixel[3] - 191) <= 1); // three quarters
        CHECK(abs(pixel[0] - stp_linear_to_srgb8(0.9f)) <= 1);
    }
    p.style.background = true;
    p.style.background_color[1] = 255;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    const uint8_t* pixel = made_picture_pixel(&p, SIDE / 2, SIDE / 2);
    CHECK_EQUAL(255, pixel[3]);
    CHECK(abs(pixel[1] - stp_linear_to_srgb8(0.75f * 0.1f + 0.25f)) <= 1);
    made_picture_end(&p);
}

/// A chequered wall behind two sheets of the same glass.
static void add_panes(made_picture* p)
{
    static const float dark[4] = {0.05f, 0.06f, 0.1f, 1.0f}, grey[4] = {0.7f, 0.8f, 0.8f, 0.3f};
    made_picture_add_material(p, 1, dark);
    made_picture_add_material(p, 2, grey);
    for (int i = 0; i < CHECKS; ++i) {
        double x = -1.25 + 1.25 * (i % 3), y = i < 3 ? -1.25 : 1.25;
        made_picture_add_sheet(p, (uint32_t)i % 2, 0.0, (stp_vec3d){x, y, -2.0 - 0.01 * i}, false);
    }
    made_picture_add_sheet(p, 2, 0.0, (stp_vec3d){-0.2, 0.0, 0.0}, false);
    made_picture_add_sheet(p, 2, 0.0, (stp_vec3d){0.2, 0.0, 1.0}, false);
}

/// The same wall behind one sheet of splats.
static void add_pane_of_splats(made_picture* p)
{
    static const float grey[4] = {0.7f, 0.8f, 0.8f, 0.3f};
    made_picture_add_material(p, 1, grey);
    made_picture_add_sheet(p, 0, 0.0, (stp_vec3d){0.3, 0.2, -2.0}, false);
    made_picture_add_sheet(p, 1, 0.2, (stp_vec3d){0.2, 0.0, 1.0}, true);
    p->quality.splat_size = 6;
}

/// Mean square of the differences of two pictures, and the mean difference, in levels.
static double find_difference(const uint8_t* a, const uint8_t* b, double* mean)
{
    double square = 0.0;
    *mean = 0.0;
    for (int i = 0; i < BYTES; ++i) {
        double d = (double)a[i] - (double)b[i];
        *mean += d / BYTES;
        square += d * d / BYTES;
    }
    return square;
}

/// In motion, the pictures differ from those at rest by rounding, not by noise.
void test_glass_in_motion_is_as_calm_as_at_rest(test_state* test)
{
    static uint8_t layers[BYTES];
    for (int splats = 0; splats < 2; ++splats) {
        made_picture p;
        begin(test, &p, 2, splats ? add_pane_of_splats : add_panes);
        for (int frame = 0; frame < 6; ++frame) {
            double mean;
            p.view.eye.x = p.view.target.x = 0.07 * frame - 0.2;
            p.style.transparency = STP_TRANSPARENCY_LAYERS;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK_EQUAL(splats ? 1 : 2, p.stats.layers);
            memcpy(layers, p.pixels, BYTES);
            p.style.transparency = STP_TRANSPARENCY_PATTERN;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK(find_difference(layers, p.pixels, &mean) > 200.0); // noise
            p.style.transparency = STP_TRANSPARENCY_NEAREST;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK_EQUAL(1, p.stats.layers);
            CHECK(find_difference(layers, p.pixels, &mean) < 1.0);
            CHECK(fabs(mean) < 0.5);
        }
        made_picture_end(&p);
    }
}

/// Layers leave nothing behind in the renderer's memory.
void test_glass_is_drawn_alike_after_any_picture(test_state* test)
{
    static uint8_t fresh[2][BYTES];
    for (int round = 0; round < 2; ++round) {
        made_picture p;
        begin(test, &p, 2, add_triangles);
        for (int i = 0; i < 6; ++i) {
            int kind = round == 0 ? i / 3 : i % 2;
            p.style.transparency = kind ? STP_TRANSPARENCY_NEAREST : STP_TRANSPARENCY_LAYERS;
            p.view.eye.x = p.view.target.x = i % 3 == 1 ? 0.6 : 0.0; // others in between
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            if (i % 3 != 1 && round == 0) {
                memcpy(fresh[kind], p.pixels, BYTES);
            } else if (i % 3 != 1) {
                CHECK(memcmp(fresh[kind], p.pixels, BYTES) == 0);
            }
        }
        made_picture_end(&p);
    }
}

/// One large sheet that fills the picture.
static void add_large_sheet(made_picture* p)
{
    static const float red[4] = {0.9f, 0.1f, 0.1f, 0.4f};
    made_picture_add_material(p, 1, red);
    made_picture_add_sheet(p, 1, 0.0, (stp_vec3d){0, 0, 3.5}, false);
}

void test_glass_patterns_stay_and_are_even(test_state* test)
{
    static uint8_t first[BYTES];
    made_picture p;
    begin(test, &p, 1, add_large_sheet);
    p.style.transparency = STP_TRANSPARENCY_PATTERN;
    for (int frame = 0; frame < 8; ++frame) {
        p.view.eye.x = p.view.target.x = 0.02 * frame;
        p.view.eye.z = 5.0 + 0.01 * frame;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        if (frame == 0) {
            memcpy(first, p.pixels, BYTES);
        }
        CHECK(memcmp(first, p.pixels, BYTES) == 0);
    }
    int all = 0;
    for (int block = 0; block < 64; ++block) { // a random pattern would leave 25.6 +- 3.9 of 64
        int there = 0;
        for (int i = 0; i < 64; ++i) {
            there += made_picture_pixel(&p, block % 8 * 8 + i % 8, block / 8 * 8 + i / 8)[3] != 0;
        }
        CHECK(there >= 22 && there <= 29);
        all += there;
    }
    CHECK(abs(all - (int)(0.4 * PIXELS)) <= 2);
    made_picture_end(&p);
}

void test_glass_without_memory_for_layers_becomes_a_pattern(test_state* test)
{
    static uint8_t pattern[BYTES];
    made_picture p;
    test_heap heap = TEST_HEAP(-1);
    CHECK(made_picture_begin(&p, &heap, 1));
    add_triangles(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    p.style.transparency = STP_TRANSPARENCY_PATTERN;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    memcpy(pattern, p.pixels, BYTES);
    p.style.transparency = STP_TRANSPARENCY_LAYERS;
    heap.fail_at = heap.count; // a warm frame allocates its pixels first
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(memcmp(pattern, p.pixels, BYTES) == 0);
    heap.fail_at = -1;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(memcmp(pattern, p.pixels, BYTES) != 0);
    made_picture_end(&p);
}

/// Draws a scene in every style on both backends.
static void compare_styles(test_state* test, made_gl* m)
{
    made_picture* p = &m->picture;
    for (int variant = 0; variant < 6; ++variant) {
        p->style.transparency = (stp_transparency)(variant / 2);
        p->style.supersample = variant & 1 ? 2 : 1;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        uint64_t covered = p->stats.covered_pixels;
        uint32_t layers = p->stats.layers;
        CHECK_EQUAL(STP_OK, made_gl_draw(m));
        CHECK_EQUAL(covered, p->stats.covered_pixels);
        CHECK_EQUAL(layers, p->stats.layers);
        CHECK(made_count_different(m->pixels, p->pixels, 2) <= PIXELS / 200);
    }
}

void test_gl_glass_matches_the_cpu(test_state* test)
{
    for (int splats = 0; splats < 2; ++splats) {
        bool failed;
        made_gl m;
        if (!made_gl_begin_with(&m, splats ? add_splats : add_triangles, NULL, NULL, &failed)) {
            made_gl_end(&m);
            CHECK(!failed);
            test->skipped = "there is no OpenGL";
            return;
        }
        compare_styles(test, &m);
        made_picture* p = &m.picture;
        p->style.transparency = STP_TRANSPARENCY_LAYERS;
        p->style.supersample = 1;
        CHECK_EQUAL(STP_OK, made_picture_accumulate(p)); // and the same as when accumulated
        CHECK_EQUAL(STP_OK, stp_renderer_accumulate(m.renderer, &p->view, &p->quality, &p->style,
                                                    &p->list, &p->image, &p->stats));
        made_gl_end(&m);
    }
}
