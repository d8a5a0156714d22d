// SPDX-License-Identifier: MIT
// Pictures of one and two eyes, in every style, in two passes: equal to single-pass pictures of
// each eye.
#include "support_picture.h"
#include "tests.h"

#include "base/math/rng.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE, PIXELS = SIDE * SIDE, SQUARES = 6, STYLES = 6 };

static const uint8_t colors[SQUARES][3] = {{230, 120, 30}, {30, 90, 220},  {40, 200, 60},
                                           {200, 60, 20},  {220, 220, 60}, {120, 40, 160}};

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

/// A wall of triangles; behind, beside and in front of it, squares of splats and triangles.
static void make_scene(made_picture* p, uint64_t round)
{
    made_picture_add(p, 0.0, (stp_vec3d){uniform(round, 1, -0.3, 0.3), 0, 1.2}, NULL);
    for (uint64_t i = 1; i < SQUARES; ++i) {
        stp_vec3d at = {uniform(round, 10 * i, -1.2, 1.2), uniform(round, 10 * i + 1, -1.0, 1.0),
                        uniform(round, 10 * i + 2, -6.0, 1.5)};
        made_picture_add(p, uniform(round, 10 * i + 3, -1.2, 1.2), at, colors[i]);
    }
    p->view.near_distance = 0.01;
    p->quality.splat_size = (float)(1 + round % 4);
}

static void choose_style(made_picture* p, int style)
{
    p->style = (stp_draw_style){.splat_scale = style == 5 ? 1.7f : 1.0f};
    p->style.supersample = style == 1 || style == 4 ? 2 : 1;
    p->style.filter = style == 2 ? STP_FILTER_EWA : STP_FILTER_NONE;
    p->style.eye_dome = style >= 3 ? 1.0f : 0.0f;
    p->style.ambient_occlusion = style == 3 ? 0.2f : 0.0f;
    p->style.background = style == 4;
}

/// The eye moves, then rests.
static void choose_view(made_picture* p, uint64_t round, int frame, bool two_eyes)
{
    double step = frame == 0 ? 1.5 : frame == 1 ? 0.2 : 0.0;
    p->view.eye = (stp_vec3d){uniform(round, 2, -1, 1) + step, uniform(round, 3, -1, 1),
                              uniform(round, 4, 3.0, 5.0) - 0.5 * step};
    p->view.target = (stp_vec3d){0.3 * step, 0, -1};
    p->view.eye_distance = two_eyes ? 0.15 : 0.0;
}

typedef struct whole_picture {
    stp_renderer* renderer;
    stp_draw_list list;
    uint8_t pixels[4 * PIXELS];
    float depth[PIXELS];
} whole_picture;

/// Draws each eye separately, in one pass.
static stp_result draw_whole(made_picture* p, whole_picture* whole)
{
    static uint8_t pixels[4 * PIXELS];
    stp_draw_stats stats;
    uint32_t eyes = stp_view_eye_count(&p->view);
    stp_result result = stp_select(p->context, p->store, &p->view, &p->quality, &whole->list);
    for (uint32_t i = 0; i < eyes && result == STP_OK; ++i) {
        stp_view one = stp_view_of_eye(&p->view, i);
        stp_image image = {one.width, one.height, pixels};
        result = stp_renderer_draw(whole->renderer, &one, &whole->list, &p->style, &image, &stats);
        size_t size = 4 * (size_t)one.width, count = (size_t)one.width * one.height;
        for (size_t y = 0; y < SIDE && result == STP_OK; ++y) {
            memcpy(whole->pixels + 4 * y * SIDE + i * size, pixels + y * size, size);
        }
        if (result == STP_OK) {
            memcpy(whole->depth + i * count, stp_renderer_depth(whole->renderer),
                   count * sizeof(float));
        }
    }
    return result;
}

static void end_whole(made_picture* p, whole_picture* whole)
{
    stp_renderer_destroy(whole->renderer);
    stp_draw_list_destroy(p->context, &whole->list);
}

void test_draw_passes_give_the_whole_picture(test_state* test)
{
    static whole_picture whole;
    uint64_t nodes = 0, fragments = 0, all_fragments = 0;
    for (uint64_t round = 0; round < 4 * STYLES; ++round) {
        bool two_eyes = round / STYLES % 2 == 0;
        made_picture p;
        stp_draw_stats stats;
        whole = (whole_picture){0};
        CHECK(made_picture_begin(&p, NULL, 1 + (uint32_t)round % 3));
        make_scene(&p, round);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, stp_draw_cpu_create(p.context, p.store, &whole.renderer));
        choose_style(&p, (int)(round % STYLES));
        for (int frame = 0; frame < 4; ++frame) {
            choose_view(&p, round, frame, two_eyes);
            CHECK_EQUAL(STP_OK, draw_whole(&p, &whole));
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK_EQUAL(0, memcmp(whole.pixels, p.pixels, sizeof(p.pixels)));
            CHECK_EQUAL(0,
                        memcmp(whole.depth, stp_renderer_depth(p.renderer), sizeof(whole.depth)));
            CHECK(p.stats.draw_calls == (two_eyes ? 2 : 1) * p.list.count);
            nodes += p.list.hidden_count;
            stp_image image = {SIDE, SIDE, whole.pixels}; // the same in one pass, two eyes at once
            fragments += p.stats.fragments;
            CHECK_EQUAL(STP_OK, stp_renderer_draw(whole.renderer, &p.view, &whole.list, &p.style,
                                                  &image, &stats));
            CHECK_EQUAL(0, memcmp(whole.pixels, p.pixels, sizeof(p.pixels)));
            CHECK_EQUAL(stats.covered_pixels, p.stats.covered_pixels);
            all_fragments += stats.fragments;
        }
        end_whole(&p, &whole);
        made_picture_end(&p);
    }
    CHECK(nodes > 50 && 20 * fragments < 19 * all_fragments); // otherwise the test proves nothing
}

void test_draw_passes_accumulate_the_whole_picture(test_state* test)
{
    static whole_picture whole;
    for (uint64_t round = 0; round < 12; ++round) {
        made_picture p;
        whole = (whole_picture){0};
        CHECK(made_picture_begin(&p, NULL, 1 + (uint32_t)round % 3));
        make_scene(&p, round);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, stp_draw_cpu_create(p.context, p.store, &whole.renderer));
        choose_style(&p, 3); // with effects: sums of bytes in both
        p.style.filter = round % 3 == 2 ? STP_FILTER_EWA : STP_FILTER_NONE;
        p.style.supersample = 3;
        choose_view(&p, round, 2, round % 2 == 0);
        CHECK_EQUAL(STP_OK, draw_whole(&p, &whole));
        for (uint32_t i = 1; i <= 9; ++i) {
            CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
            CHECK_EQUAL(i, p.stats.samples);
        }
        CHECK_EQUAL(0, memcmp(whole.pixels, p.pixels, sizeof(p.pixels)));
        end_whole(&p, &whole);
        made_picture_end(&p);
    }
}

void test_draw_passes_allocate_nothing_in_warm_frames(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    made_picture p;
    CHECK(made_picture_begin(&p, &heap, 3));
    make_scene(&p, 1);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    int before = 0;
    for (int frame = 0; frame < 24; ++frame) {
        before = frame == 12 ? heap.count : before;
        choose_style(&p, frame / 2 % STYLES);
        choose_view(&p, 1, frame % 4, frame % 2 == 0);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    }
    CHECK_EQUAL(before, heap.count);
    made_picture_end(&p);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_draw_passes_survive_failing_allocator(test_state* test)
{
    static uint8_t expected[4 * PIXELS];
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_scene(&p, 1);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        choose_style(&p, n % 2 == 0 ? 0 : 1);
        choose_view(&p, 1, 2, true);
        heap.fail_at = heap.count + n / 2;
        stp_result result = made_picture_draw(&p);
        result = result == STP_OK ? made_picture_draw(&p) : result;
        heap.fail_at = -1;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        if (n < 2) {
            memcpy(expected, p.pixels, sizeof(expected));
        } else if (n % 2 == 1) {
            CHECK_EQUAL(0, memcmp(expected, p.pixels, sizeof(expected)));
        }
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK && n % 2 == 1) {
            CHECK(n >= 30);
            break;
        }
    }
}

void test_draw_passes_of_an_odd_width(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 1));
    make_scene(&p, 3);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    choose_style(&p, 0);
    choose_view(&p, 3, 2, true);
    memset(p.pixels, 1, sizeof(p.pixels));
    p.view.width = p.image.width = 47;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    for (int y = 0; y < SIDE; ++y) {
        CHECK_EQUAL(0, p.pixels[4 * (47 * y + 46) + 3]);
    }
    CHECK_EQUAL(1, p.pixels[4 * 47 * SIDE]);
    made_picture_end(&p);
}
