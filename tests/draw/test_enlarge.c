// SPDX-License-Identifier: MIT
// Pictures at a lower resolution: enlarged, against bilinear interpolation in double.
#include "support_picture.h"
#include "tests.h"

#include "base/core/context.h"
#include "base/math/rng.h"
#include "draw/enlarge.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 61, HEIGHT = 47, PIXELS = WIDTH * HEIGHT };

/// One channel of a picture between its pixels: colours count by their alpha.
static double interpolate(const stp_image* from, uint32_t first, uint32_t width, double x, double y,
                          int channel)
{
    x = fmin(fmax(x, 0.0), (double)width - 1.0);
    y = fmin(fmax(y, 0.0), (double)from->height - 1.0);
    double sum = 0.0, alpha = 0.0;
    for (int i = 0; i < 4; ++i) {
        double px = floor(x) + (double)(i & 1), py = floor(y) + (double)(i >> 1);
        double weight = (1.0 - fabs(x - px)) * (1.0 - fabs(y - py));
        if (!(weight > 0.0)) {
            continue;
        }
        const uint8_t* p = from->pixels + 4 * ((size_t)py * from->width + first + (size_t)px);
        alpha += weight * p[3];
        sum += weight * p[3] * (channel == 3 ? 1.0 : (double)p[channel]);
    }
    return channel == 3 ? alpha : alpha > 0.0 ? sum / alpha : 0.0;
}

/// The largest difference of a channel from interpolation. Hardly visible colours do not count.
static double compare(const stp_image* small, uint32_t eyes, const stp_image* image)
{
    double most = 0.0;
    uint32_t width = image->width / eyes, small_width = small->width / eyes;
    for (uint32_t i = 0; i < image->height * width * eyes; ++i) {
        uint32_t x = i % (width * eyes), y = i / (width * eyes), eye = x / width;
        const uint8_t* got = image->pixels + 4 * ((size_t)y * image->width + x);
        double at_x = (x % width + 0.5) * small_width / width - 0.5;
        double at_y = (y + 0.5) * small->height / image->height - 0.5;
        for (int c = 0; c < 4; ++c) {
            double expected = interpolate(small, eye * small_width, small_width, at_x, at_y, c);
            double allowed = c == 3 || got[3] == 255 ? 1.0 : 255.0 / (got[3] + 1.0);
            most = fmax(most, fabs(expected - got[c]) / allowed);
        }
    }
    return most;
}

static void fill(uint64_t round, stp_image* image)
{
    for (uint32_t i = 0; i < image->width * image->height; ++i) {
        uint64_t bits = stp_rng_hash(round, i);
        bool open = round % 3 == 1 && bits >> 60 < 5;
        for (int c = 0; c < 4; ++c) {
            image->pixels[4 * i + (uint32_t)c] = open ? 0 : (uint8_t)(bits >> 8 * c);
        }
        image->pixels[4 * i + 3] = open ? 0 : round % 3 == 2 ? (uint8_t)(bits >> 24) : 255;
    }
}

void test_enlarge_interpolates(test_state* test)
{
    static uint8_t pixels[4 * PIXELS];
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_enlargement e = {0};
    for (uint64_t round = 0; round < 24; ++round) {
        uint32_t eyes = round % 4 == 3 ? 2 : 1;
        stp_view view = {.width = WIDTH - (uint32_t)round, .height = HEIGHT};
        view.eye_distance = eyes == 2 ? 0.1 : 0.0;
        stp_view less = stp_enlarge_view(&view, 0.5 + 0.03 * (double)(round % 16));
        CHECK(less.width <= view.width && less.height < view.height && less.width % eyes == 0);
        stp_image small, image = {view.width, view.height, pixels};
        CHECK_EQUAL(STP_OK, stp_enlarge_begin(context, &less, &e, &small));
        fill(round, &small);
        memset(pixels, 77, sizeof(pixels));
        CHECK_EQUAL(STP_OK, stp_enlarge_picture(context, &e, &small, eyes, &image));
        CHECK(compare(&small, eyes, &image) < 2.6); // three roundings
        const uint8_t* last = pixels + 4 * ((size_t)view.width - 1);
        CHECK(eyes == 1 || view.width % 2 == 0 || last[3] == 0); // belongs to no eye
    }
    stp_enlargement_destroy(context, &e);
    stp_context_destroy(context);
}

void test_enlarge_keeps_a_pixel(test_state* test)
{
    stp_view view = {.width = 1, .height = 3};
    stp_view less = stp_enlarge_view(&view, 0.01);
    CHECK(less.width == 1 && less.height == 1);
    view.eye_distance = 0.1;
    view.width = 5;
    less = stp_enlarge_view(&view, 0.01);
    CHECK(less.width == 2 && less.height == 1);
}

static stp_result draw_at(made_picture* p, float resolution)
{
    p->style.resolution = resolution;
    return stp_renderer_draw_selected(p->renderer, &p->view, &p->quality, &p->style, &p->list,
                                      &p->image, &p->stats);
}

static const uint8_t grey[3] = {120, 90, 60};

/// A scene of triangles and splats, drawn at half the resolution, is the enlarged small picture.
void test_enlarge_draws_at_a_resolution(test_state* test)
{
    static made_picture p;
    static uint8_t whole[sizeof(p.pixels)], half[sizeof(p.pixels)], expected[sizeof(p.pixels)];
    CHECK(made_picture_begin(&p, NULL, 2));
    made_picture_add(&p, 0.5, (stp_vec3d){0.3, 0, 0}, NULL);
    made_picture_add(&p, 0.0, (stp_vec3d){-0.4, 0.5, 0.7}, grey);
    p.quality.splat_size = 3;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, draw_at(&p, 1.0f));
    memcpy(whole, p.pixels, sizeof(whole));
    uint64_t covered = p.stats.covered_pixels;
    CHECK_EQUAL(STP_OK, draw_at(&p, 0.5f));
    memcpy(half, p.pixels, sizeof(half));
    CHECK(p.stats.covered_pixels < covered / 3 && p.stats.covered_pixels > covered / 5);
    const float* depth = stp_renderer_depth(p.renderer);
    int same = 0;
    for (uint32_t i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        same += (depth[i] > 0.0f) == (half[4 * i + 3] > 127);
    }
    CHECK(same == PICTURE_SIDE * PICTURE_SIDE);

    const stp_view view = p.view;
    const stp_image image = p.image;
    stp_enlargement e = {0};
    stp_image small, out = {PICTURE_SIDE, PICTURE_SIDE, expected};
    p.view = stp_enlarge_view(&view, 0.5);
    CHECK_EQUAL(STP_OK, stp_enlarge_begin(p.context, &p.view, &e, &small));
    p.image = small;
    CHECK_EQUAL(STP_OK, draw_at(&p, 0.0f));
    CHECK_EQUAL(STP_OK, stp_enlarge_picture(p.context, &e, &small, 1, &out));
    CHECK_EQUAL(0, memcmp(expected, half, sizeof(half)));
    stp_enlargement_destroy(p.context, &e);

    p.view = view;
    p.image = image;
    CHECK_EQUAL(STP_OK, draw_at(&p, 0.0f)); // the occlusion of small pictures hides nothing else
    CHECK_EQUAL(0, memcmp(whole, p.pixels, sizeof(whole)));
    made_picture_end(&p);
}

void test_enlarge_reports_missing_memory(test_state* test)
{
    static made_picture p;
    int failed = 0;
    for (int fail_at = 0; failed == fail_at; ++fail_at) {
        test_heap heap = TEST_HEAP(-1);
        CHECK(made_picture_begin(&p, &heap, 1));
        made_picture_add(&p, 0.5, (stp_vec3d){0.3, 0, 0}, NULL);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, draw_at(&p, 0.0f));
        heap.fail_at = heap.count + fail_at;
        stp_result result = draw_at(&p, 0.5f);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        failed += result != STP_OK;
        heap.fail_at = -1;
        CHECK_EQUAL(STP_OK, draw_at(&p, 0.5f));
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(failed >= 3);
}
