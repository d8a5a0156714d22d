// SPDX-License-Identifier: MIT
// Occlusion by the pyramid, against brute force over points.
#include "pyramid_helpers.h"
#include "tests.h"

#include "base/core/context.h"
#include "base/math/math.h"
#include "base/math/rng.h"

#include <string.h>

enum { MAX_WIDTH = 201, MAX_HEIGHT = 133 };

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

// Rectangles at several depths in front of a back wall, sometimes with holes to the background.
static void make_picture(uint64_t round, const stp_view* view, float* nearness)
{
    for (uint32_t i = 0; i < view->width * view->height; ++i) {
        nearness[i] = (float)(view->near_distance / 20.0);
    }
    for (uint64_t k = 0; k < 12; ++k) {
        double depth = uniform(round, 10 + 5 * k, 1.0, 10.0);
        uint32_t x0 = (uint32_t)uniform(round, 11 + 5 * k, 0, view->width);
        uint32_t y0 = (uint32_t)uniform(round, 12 + 5 * k, 0, view->height);
        uint32_t x1 = x0 + (uint32_t)uniform(round, 13 + 5 * k, 1, 120);
        uint32_t y1 = y0 + (uint32_t)uniform(round, 14 + 5 * k, 1, 90);
        for (uint32_t y = y0; y < y1 && y < view->height; ++y) {
            for (uint32_t x = x0; x < x1 && x < view->width; ++x) {
                float* at = &nearness[y * view->width + x];
                *at = k == 11 && round % 4 == 0 ? 0.0f : (float)(view->near_distance / depth);
            }
        }
    }
}

// Whether a point and its surroundings of `margin` pixels are farther than the picture's depth plus
// a distance.
static bool is_hidden(const stp_view_frame* f, const float* nearness, stp_vec3d p, double margin)
{
    stp_vec3d q = stp_subd(p, f->eye);
    double z = stp_dotd(q, f->forward);
    double closest = z * (1.0 - margin / f->scale), behind = 1.0 + margin / f->scale;
    if (closest <= f->near_distance) {
        return false;
    }
    double x = f->center_x + f->scale * stp_dotd(q, f->right) / z;
    double y = f->center_y + f->scale * stp_dotd(q, f->down) / z;
    for (double v = floor(y - margin); v <= y + margin; v += 1.0) {
        for (double u = floor(x - margin); u <= x + margin; u += 1.0) {
            bool inside = u >= 0 && v >= 0 && u < f->width && v < f->height;
            if (inside && !((double)nearness[(size_t)v * (size_t)f->width + (size_t)u] >
                            behind * f->near_distance / closest)) {
                return false;
            }
        }
    }
    return true;
}

void test_depth_pyramid_never_hides_what_can_be_seen(test_state* test)
{
    static float nearness[MAX_WIDTH * MAX_HEIGHT];
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_depth_pyramid pyramid = {0};
    int hidden = 0, wrongly_kept = 0;
    for (uint64_t round = 0; round < 60; ++round) {
        stp_view view = {.eye = {0.3, -0.2, 0.1},
                         .target = {uniform(round, 0, -5, 5), uniform(round, 1, -5, 5),
                                    uniform(round, 2, -5, 5)},
                         .up = {0, 1, 0},
                         .fov_degrees = 70,
                         .near_distance = 0.01,
                         .width = round % 3 == 0 ? 64 : MAX_WIDTH - (uint32_t)round % 7,
                         .height = round % 3 == 0 ? 8 : MAX_HEIGHT - (uint32_t)round % 11};
        make_picture(round, &view, nearness);
        CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
        const stp_view_frame* f = &pyramid.frame;
        for (uint64_t k = 0; k < 40; ++k) {
            double depth = uniform(round, 100 + 8 * k, 0.3, 24.0), slope = 0.6;
            stp_vec3d c = stp_addd(
                f->eye,
                stp_scaled(
                    stp_addd(
                        f->forward,
                        stp_addd(stp_scaled(f->right, uniform(round, 101 + 8 * k, -slope, slope)),
                                 stp_scaled(f->down, uniform(round, 102 + 8 * k, -slope, slope)))),
                    depth));
            double size = depth * uniform(round, 103 + 8 * k, 0.002, 0.2);
            stp_vec3d half = {size * uniform(round, 104 + 8 * k, 0, 1),
                              size * uniform(round, 105 + 8 * k, 0, 1),
                              size * uniform(round, 106 + 8 * k, 0, 1)};
            stp_boxd box = {stp_subd(c, half), stp_addd(c, half)};
            double margin = uniform(round, 107 + 8 * k, 0.0, 3.0);
            bool truly = true;
            for (int i = 0; i < 125 && truly; ++i) {
                stp_vec3d p = {box.min.x + half.x * 0.5 * (i % 5),
                               box.min.y + half.y * 0.5 * (i / 5 % 5),
                               box.min.z + half.z * 0.5 * (i / 25)};
                truly = is_hidden(f, nearness, p, margin);
            }
            bool said = stp_depth_pyramid_hides(&pyramid, &box, margin);
            CHECK(truly || !said);
            hidden += said;
            wrongly_kept += truly && !said;
        }
    }
    CHECK(hidden > 200 && wrongly_kept < hidden);
    stp_depth_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

/// Nearest depth at which the ray through a pixel's centre is in a box; 0: it misses.
static double enter_box(const stp_view_frame* f, const stp_boxd* box, uint32_t x, uint32_t y)
{
    stp_vec3d ray =
        stp_addd(f->forward, stp_addd(stp_scaled(f->right, (x + 0.5 - f->center_x) / f->scale),
                                      stp_scaled(f->down, (y + 0.5 - f->center_y) / f->scale)));
    const double from[3] = {f->eye.x, f->eye.y, f->eye.z}, along[3] = {ray.x, ray.y, ray.z};
    const double low[3] = {box->min.x, box->min.y, box->min.z};
    const double high[3] = {box->max.x, box->max.y, box->max.z};
    double begin = 0.0, end = HUGE_VAL;
    for (int k = 0; k < 3; ++k) {
        double a = (low[k] - from[k]) / along[k], b = (high[k] - from[k]) / along[k];
        begin = fmax(begin, fmin(a, b));
        end = fmin(end, fmax(a, b));
    }
    return begin <= end ? begin : 0.0;
}

// Triangles in a box hit pixels whose centres are inside; theirs and those of the picture are
// pushed back alike.
void test_depth_pyramid_hides_triangles_exactly(test_state* test)
{
    static float nearness[MAX_WIDTH * MAX_HEIGHT];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_depth_pyramid pyramid = {0};
    const float nowhere[3] = {0.0f, 0.0f, 0.0f};
    int hidden = 0, kept = 0, more = 0;
    for (uint64_t round = 0; round < 40; ++round) {
        stp_view view = {.eye = {0.3, -0.2, 0.1},
                         .target = {uniform(round, 0, -5, 5), uniform(round, 1, -5, 5),
                                    uniform(round, 2, -5, 5)},
                         .up = {0, 1, 0},
                         .fov_degrees = 70,
                         .near_distance = 0.01,
                         .width = MAX_WIDTH - (uint32_t)round % 7,
                         .height = MAX_HEIGHT - (uint32_t)round % 11};
        make_picture(round, &view, nearness);
        CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
        CHECK(pyramid.pushed_back == 1.0);
        pyramid.pushed_back = 1.0 + 0.02 * (double)(round % 3);
        const stp_view_frame* f = &pyramid.frame;
        const stp_vec3d axes[3] = {f->right, f->down, f->forward};
        double rows[3][4];
        for (int k = 0; k < 3; ++k) {
            memcpy(rows[k], &axes[k], 3 * sizeof(double));
            rows[k][3] = -stp_dotd(axes[k], f->eye);
        }
        for (uint64_t k = 0; k < 60; ++k) {
            double depth = uniform(round, 100 + 8 * k, 0.3, 24.0);
            double across = uniform(round, 101 + 8 * k, -0.8, 0.8);
            double below = uniform(round, 102 + 8 * k, -0.8, 0.8);
            stp_vec3d aside = stp_addd(stp_scaled(f->right, across), stp_scaled(f->down, below));
            stp_vec3d c = stp_addd(f->eye, stp_scaled(stp_addd(f->forward, aside), depth));
            double size = depth * uniform(round, 103 + 8 * k, 0.002, 0.2);
            stp_vec3d half = {size * uniform(round, 104 + 8 * k, 0, 1),
                              size * uniform(round, 105 + 8 * k, 0, 1),
                              size * uniform(round, 106 + 8 * k, 0, 1)};
            stp_boxd box = {stp_subd(c, half), stp_addd(c, half)};
            bool truly = true;
            for (uint32_t y = 0; y < view.height; ++y) {
                for (uint32_t x = 0; x < view.width; ++x) {
                    double z = enter_box(f, &box, x, y) * pyramid.pushed_back;
                    truly = truly && (!(z > 0.0) ||
                                      (double)nearness[y * view.width + x] > f->near_distance / z);
                }
            }
            bool said = stp_depth_pyramid_hides_triangles(&pyramid, (const double(*)[4])rows,
                                                          nowhere, &box);
            CHECK(truly || !said);
            hidden += said;
            kept += truly && !said;
            more += said && !stp_depth_pyramid_hides(&pyramid, &box, 0.0);
        }
    }
    CHECK(hidden > 200 && kept < hidden && more > 20);
    stp_depth_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

/// A view along z of a wall at depth 2, of 64 x 64 pixels.
static stp_view make_wall(float* nearness)
{
    for (int i = 0; i < 64 * 64; ++i) {
        nearness[i] = 0.01f / 2.0f;
    }
    return (stp_view){.target = {0, 0, 1},
                      .up = {0, 1, 0},
                      .fov_degrees = 60,
                      .near_distance = 0.01,
                      .width = 64,
                      .height = 64};
}

// Far from where coordinates are relative to, they are rounded more: less is hidden.
void test_depth_pyramid_hides_by_the_precision_of_drawing(test_state* test)
{
    static float nearness[64 * 64];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    const stp_view view = make_wall(nearness);
    stp_depth_pyramid pyramid = {0};
    CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
    const double rows[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const float nearby[3] = {0.0f, 0.0f, 0.0f}, far[3] = {1000.0f, 20.0f, 1000.0f};
    const stp_boxd close = {{-0.1, -0.1, 2.0001}, {0.1, 0.1, 2.1}};
    const stp_boxd behind = {{-0.1, -0.1, 2.1}, {0.1, 0.1, 2.2}};
    CHECK(stp_depth_pyramid_hides_triangles(&pyramid, rows, nearby, &close));
    CHECK(!stp_depth_pyramid_hides_triangles(&pyramid, rows, far, &close));
    CHECK(stp_depth_pyramid_hides_triangles(&pyramid, rows, far, &behind));
    stp_depth_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

void test_depth_pyramid_hides_nothing_undecided(test_state* test)
{
    static float nearness[64 * 64];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_depth_pyramid pyramid = {0};
    stp_boxd behind = {{-0.1, -0.1, 9}, {0.1, 0.1, 9.1}}, around = {{-1, -1, -1}, {1, 1, 1}};
    stp_boxd aside = {{50, 0, 5}, {51, 1, 6}}, back = {{-1, -1, -9}, {1, 1, -8}};
    CHECK(!stp_depth_pyramid_hides(&pyramid, &behind, 1.0)); // the pyramid of an empty picture
    const stp_view view = make_wall(nearness);
    CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
    CHECK(stp_depth_pyramid_hides(&pyramid, &behind, 1.0));
    CHECK(!stp_depth_pyramid_hides(&pyramid, &around, 1.0));
    CHECK(!stp_depth_pyramid_hides(&pyramid, &aside, 1.0));
    CHECK(!stp_depth_pyramid_hides(&pyramid, &back, 1.0));
    CHECK(!stp_depth_pyramid_hides(&pyramid, &behind, 1e9));
    nearness[32 * 64 + 33] = 0.0f; // one pixel of background
    CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
    CHECK(!stp_depth_pyramid_hides(&pyramid, &behind, 1.0));
    stp_depth_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

// Any number of threads; out of memory; and a second frame allocates nothing.
void test_depth_pyramid_memory_and_threads(test_state* test)
{
    static float nearness[MAX_WIDTH * MAX_HEIGHT];
    stp_view view = {.target = {0, 0, 1},
                     .up = {0, 1, 0},
                     .fov_degrees = 60,
                     .near_distance = 0.01,
                     .width = MAX_WIDTH,
                     .height = MAX_HEIGHT};
    make_picture(4, &view, nearness);
    float first[51 * 34];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        stp_depth_pyramid pyramid = {0};
        CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
        CHECK_EQUAL(51, pyramid.columns[0]);
        CHECK_EQUAL(34, pyramid.rows[0]);
        CHECK_EQUAL(26, pyramid.columns[1]);
        CHECK_EQUAL(17, pyramid.rows[1]);
        if (threads == 1) {
            memcpy(first, pyramid.levels[0], sizeof(first));
        }
        CHECK_EQUAL(0, memcmp(first, pyramid.levels[0], sizeof(first)));
        stp_depth_pyramid_destroy(context, &pyramid);
        stp_context_destroy(context);
    }
    test_heap heap = TEST_HEAP(-1);
    stp_context* context = test_context(&heap, 1, NULL);
    CHECK(context != NULL);
    stp_depth_pyramid pyramid = {0};
    heap.fail_at = heap.count;
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, make_pyramid(context, &view, nearness, &pyramid));
    heap.fail_at = -1;
    CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
    int count = heap.count;
    view.width -= 40;
    CHECK_EQUAL(STP_OK, make_pyramid(context, &view, nearness, &pyramid));
    CHECK_EQUAL(count, heap.count);
    stp_depth_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
}
