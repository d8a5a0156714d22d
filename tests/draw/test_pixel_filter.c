// SPDX-License-Identifier: MIT
// The pixel filter against plain means of nine pixels: which pictures it changes, and how.
#include "support_gl.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "draw/cpu/pixel_filter.h"

#include <math.h>
#include <string.h>

enum { SIDE = PICTURE_SIDE, ROW = 173, EDGE = 4 };

static const uint8_t grey[3] = {120, 120, 120};

typedef struct rows {
    uint8_t in[3][4 * ROW], kinds[ROW], out[4 * ROW];
    uint16_t light[3][4 * ROW + 2 * EDGE], weights[4 * ROW], across[3][4 * ROW], mixed[4 * ROW];
} rows;

/// All kernels, applied to rows of random pixels that are open or covered.
static void run_kernels(const stp_cpu_pixel_kernels* k, rows* r)
{
    uint64_t state = 0;
    memset(r, 0, sizeof(*r));
    for (int x = 0; x < ROW; ++x) {
        r->kinds[x] = (uint8_t)(stp_rng_hash(1, state++) & 1u);
    }
    k->weigh(r->kinds, r->weights, ROW);
    for (int y = 0; y < 3; ++y) {
        for (int x = 0; x < ROW; ++x) {
            bool there = (stp_rng_hash(2, state++) & 7u) > 2u;
            for (int c = 0; c < 4; ++c) {
                uint8_t value = c == 3 ? 255 : (uint8_t)stp_rng_hash(3, state++);
                r->in[y][4 * x + c] = there ? value : 0;
            }
        }
        k->light(r->in[y], r->light[y] + EDGE, ROW);
        k->across(r->light[y] + EDGE, r->weights, r->across[y], ROW);
    }
    const uint16_t* const lines[3] = {r->across[0], r->across[1], r->across[2]};
    k->down(lines, r->weights, r->mixed, r->out, ROW);
}

void test_pixel_filter_kernels_agree(test_state* test)
{
    static rows expected, got;
    run_kernels(&stp_cpu_pixel_kernels_portable, &expected);
    for (int i = 0; i < 4 * ROW; ++i) {
        uint32_t byte = expected.in[1][i];
        CHECK_EQUAL(byte * byte, expected.light[1][EDGE + i]);
    }
    if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
        run_kernels(&STP_VECTOR(stp_cpu_pixel_kernels), &got);
        CHECK_EQUAL(0, memcmp(&expected, &got, sizeof(got)));
    }
    if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
        run_kernels(&STP_WIDE(stp_cpu_pixel_kernels), &got);
        CHECK_EQUAL(0, memcmp(&expected, &got, sizeof(got)));
    }
}

/// White triangles, of which grey splats hide a part.
static void make_squares(made_picture* p)
{
    made_picture_add(p, 0.5, (stp_vec3d){0.3, 0, 0}, NULL);
    made_picture_add(p, 0.0, (stp_vec3d){-0.4, 0.5, 0.7}, grey);
    p->quality.splat_size = 3;
    p->quality.splats_only = true;
}

/// A picture, or one eye's part of it.
typedef struct area {
    int width, height, stride; ///< pixels
} area;

/// One channel of the mean of the pixels around (x, y): of light times coverage; c = 3: coverage.
/// Splats are those that are grey.
static double mean_at(const uint8_t* pixels, const area* a, int x, int y, int c)
{
    double sum = 0.0;
    for (int j = -1; j <= 1; ++j) {
        int row = y + j < 0 ? 0 : y + j >= a->height ? a->height - 1 : y + j;
        const uint8_t* own = pixels + 4 * (row * a->stride + x);
        const uint8_t* here = pixels + 4 * (y * a->stride + x);
        double k = own[0] == grey[0] ? 0.14 : 0.09, down = here[0] == grey[0] ? 0.14 : 0.09;
        double line = 0.0;
        for (int i = -1; i <= 1; ++i) {
            int column = x + i < 0 ? 0 : x + i >= a->width ? a->width - 1 : x + i;
            const uint8_t* at = pixels + 4 * (row * a->stride + column);
            double value = c < 3 ? (double)at[c] * at[c] / 65025.0 * at[3] / 255.0 : at[3] / 255.0;
            line += (i == 0 ? 1.0 - 2.0 * k : k) * value;
        }
        sum += (j == 0 ? 1.0 - 2.0 * down : down) * line;
    }
    return sum;
}

/// Compares a filtered picture with an unfiltered one. @return how many pixels changed
static int compare(test_state* test, const uint8_t* before, const uint8_t* after, const area* a)
{
    int changed = 0;
    for (int y = 0; y < a->height; ++y) {
        for (int x = 0; x < a->width; ++x) {
            int at = 4 * (y * a->stride + x);
            double coverage = mean_at(before, a, x, y, 3);
            CHECK(fabs(coverage * 255.0 - after[at + 3]) < 1.6);
            double off = coverage > 0.05 ? 1.6 : 8.0; // colours of nearly nothing are rounded
            for (int c = 0; c < 3; ++c) {
                double light = coverage > 0.0 ? mean_at(before, a, x, y, c) / coverage : 0.0;
                CHECK(fabs(sqrt(light) * 255.0 - after[at + c]) < off);
            }
            changed += memcmp(before + at, after + at, 4) != 0 ? 1 : 0;
        }
    }
    return changed;
}

void test_pixel_filter_is_a_mean_of_nine_pixels(test_state* test)
{
    static uint8_t before[SIDE * SIDE * 4], first[2][SIDE * SIDE * 4];
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, threads));
        make_squares(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (int i = 0; i < 2; ++i) {
            p.style = (stp_draw_style){.background = i == 1, .background_color = {30, 90, 200}};
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            uint64_t covered = p.stats.covered_pixels;
            CHECK(covered > 400 && p.stats.splats > 0);
            memcpy(before, p.pixels, sizeof(before));
            p.style.pixel_filter = true;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK_EQUAL(covered, p.stats.covered_pixels);
            int changed = compare(test, before, p.pixels, &(area){SIDE, SIDE, SIDE});
            CHECK(changed > 200 && changed < 1200); // flat areas stay exactly as they are
            if (threads == 1) {
                memcpy(first[i], p.pixels, sizeof(first[i]));
            }
            CHECK_EQUAL(0, memcmp(first[i], p.pixels, sizeof(first[i])));
        }
        made_picture_end(&p);
    }
}

/// Bands, rows and columns end anywhere; warm frames do not depend on frames before them.
void test_pixel_filter_of_every_size(test_state* test)
{
    static const uint32_t sizes[][2] = {{1, 1},   {1, 40},  {40, 1}, {3, 2},
                                        {17, 33}, {63, 16}, {64, 48}};
    static uint8_t before[SIDE * SIDE * 4];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_squares(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        p.view.width = p.image.width = sizes[i][0];
        p.view.height = p.image.height = sizes[i][1];
        p.style.pixel_filter = false;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        memcpy(before, p.pixels, sizeof(before));
        p.style.pixel_filter = true;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        int width = (int)sizes[i][0], height = (int)sizes[i][1];
        compare(test, before, p.pixels, &(area){width, height, width});
    }
    made_picture_end(&p);
}

/// Pictures of several samples need no filter: summed, accumulated, and with effects on each.
void test_pixel_filter_leaves_several_samples_alone(test_state* test)
{
    static uint8_t before[SIDE * SIDE * 4];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_squares(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    for (int i = 0; i < 6; ++i) {
        p.style = (stp_draw_style){
            .supersample = 2, .pixel_filter = i % 2 == 1, .eye_dome = i / 2 == 1 ? 1.0f : 0.0f};
        CHECK_EQUAL(STP_OK, i / 2 == 2 ? made_picture_accumulate(&p) : made_picture_draw(&p));
        if (i % 2 == 0) {
            memcpy(before, p.pixels, sizeof(before));
        }
        CHECK_EQUAL(0, memcmp(before, p.pixels, sizeof(before)));
    }
    made_picture_end(&p);
}

/// Glass before nothing and before a wall: pixels that are neither open nor covered.
static void make_panes(made_picture* p)
{
    static const float wall[4] = {0.6f, 0.7f, 0.9f, 1.0f}, glass[4] = {0.1f, 0.7f, 0.3f, 0.45f};
    made_picture_add_material(p, 1, wall);
    made_picture_add_material(p, 2, glass);
    made_picture_add_sheet(p, 1, 0.5, (stp_vec3d){-1.9, 0.3, 0}, false);
    made_picture_add_sheet(p, 2, 0.2, (stp_vec3d){0.2, 0.1, 1.0}, false);
    made_picture_add_sheet(p, 2, 0.0, (stp_vec3d){1.6, 0.4, -0.5}, false);
}

enum { WIDE = 260, WIDE_BYTES = WIDE * 48 * 4 };

static int count_partial(const uint8_t* pixels, int count)
{
    int partial = 0;
    for (int i = 0; i < count; ++i) {
        partial += pixels[4 * i + 3] > 0 && pixels[4 * i + 3] < 255 ? 1 : 0;
    }
    return partial;
}

/// Draws pictures of several widths, for one and two eyes, without and with the filter.
static void filter_panes(test_state* test, made_picture* p, stp_renderer* renderer)
{
    static const uint32_t widths[] = {65, 100, 130};
    static uint8_t before[WIDE_BYTES], after[WIDE_BYTES];
    for (uint32_t i = 0; i < 6; ++i) {
        uint32_t eyes = i / 3 + 1, width = eyes * widths[i % 3];
        stp_image image = {width, 48, before};
        p->view.width = width;
        p->view.height = 48;
        p->view.eye_distance = eyes == 2 ? 0.3 : 0.0;
        for (int filtered = 0; filtered < 2; ++filtered) {
            image.pixels = filtered ? after : before;
            p->style.pixel_filter = filtered != 0;
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(renderer, &p->view, &p->quality,
                                                           &p->style, &p->list, &image, &p->stats));
            CHECK(p->stats.layers > 0);
        }
        CHECK(count_partial(before, (int)width * 48) > 300);
        const area eye = {(int)widths[i % 3], 48, (int)width};
        for (uint32_t k = 0; k < eyes; ++k) {
            int changed =
                compare(test, before + 4 * k * widths[i % 3], after + 4 * k * widths[i % 3], &eye);
            CHECK(changed > 100);
        }
    }
}

void test_pixel_filter_of_glass_and_of_two_eyes(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_panes(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    filter_panes(test, &p, p.renderer);
    made_picture_end(&p);
}

void test_gl_pixel_filter_of_glass_and_of_two_eyes(test_state* test)
{
    bool failed;
    made_gl m;
    if (!made_gl_begin_with(&m, make_panes, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    filter_panes(test, &m.picture, m.renderer);
    made_gl_end(&m);
}

/// A small filtered frame that is stopped or fails leaves nothing to a larger one without a filter.
void test_pixel_filter_ends_with_its_frame(test_state* test)
{
    static uint8_t wide[WIDE_BYTES];
    int failures = 0;
    for (int n = 0; n < 40; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_squares(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        p.view.width = p.view.height = p.image.width = p.image.height = 8;
        p.style = (stp_draw_style){.pixel_filter = true, .eye_dome = 1.0f};
        heap.fail_at = heap.count + n;
        failures += made_picture_draw(&p) != STP_OK ? 1 : 0;
        heap.fail_at = -1;
        CHECK(((const stp_cpu_renderer*)p.renderer)->pixel_filter.kinds == NULL);
        p.style = (stp_draw_style){.supersample = 1};
        p.view.width = WIDE;
        p.view.height = 48;
        p.image = (stp_image){WIDE, 48, wide};
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        made_picture_end(&p);
    }
    CHECK(failures > 8);
}

/// Without memory for the filter, the picture is that without a filter, with one warning.
void test_pixel_filter_without_memory_leaves_the_picture(test_state* test)
{
    static uint8_t before[SIDE * SIDE * 4];
    test_heap heap = TEST_HEAP(-1);
    made_picture p;
    CHECK(made_picture_begin(&p, &heap, 1));
    make_squares(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    memcpy(before, p.pixels, sizeof(before));
    p.style.pixel_filter = true;
    for (int i = 0; i < 2; ++i) {
        heap.fail_at = heap.count; // a warm frame allocates nothing else
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, memcmp(before, p.pixels, sizeof(before)));
        CHECK(((const stp_cpu_renderer*)p.renderer)->pixel_filter.warned);
    }
    heap.fail_at = -1;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(memcmp(before, p.pixels, sizeof(before)) != 0);
    made_picture_end(&p);
}

void test_pixel_filter_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_squares(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        p.style.pixel_filter = true;
        heap.fail_at = heap.count + n;
        stp_result result = made_picture_draw(&p);
        bool failed = heap.count > heap.fail_at; // but a picture without its filter is drawn
        heap.fail_at = -1;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p)); // after a failure the next frame is correct
        CHECK(p.stats.covered_pixels > 400);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p)); // knows what is hidden
        int warm = heap.count;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(warm, heap.count); // a warm frame allocates nothing
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
        if (!failed) {
            CHECK(n >= 8 && result == STP_OK);
            break;
        }
    }
}
