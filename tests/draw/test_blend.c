// SPDX-License-Identifier: MIT
// Overlapping splats are blended within a surface, but not across surfaces.
#include "support_picture.h"
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/coverage.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE, BYTES = SIDE * SIDE * 4 };

static const uint8_t red[3] = {255, 0, 0}, blue[3] = {0, 0, 255};

static void make_noisy(made_picture* p)
{
    stp_splats* s = &p->scene.sets[0];
    for (uint32_t i = 0; i < 3 * s->count; ++i) {
        s->colors[i] = (uint8_t)(90 + stp_rng_hash(3, i / 3) % 120);
    }
}

typedef struct spread {
    double mean, variance;
} spread;

static spread measure(const made_picture* p)
{
    double sum = 0.0, squares = 0.0, count = 0.0;
    for (int y = 22; y < 42; ++y) {
        for (int x = 22; x < 42; ++x) {
            double v = made_picture_pixel(p, x, y)[1];
            sum += v;
            squares += v * v;
            count += 1.0;
        }
    }
    return (spread){sum / count, squares / count - sum / count * (sum / count)};
}

void test_blend_takes_noise_away(test_state* test)
{
    for (int variant = 0; variant < 2; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 2));
        p.view.ortho_height = variant == 0 ? 0 : 4;
        made_picture_add(&p, 0.3, (stp_vec3d){0}, red);
        make_noisy(&p);
        p.quality.splat_size = 6;
        p.quality.splat_count = 900;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        spread plain = measure(&p);
        uint64_t covered = p.stats.covered_pixels;
        p.style.filter = STP_FILTER_EWA;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        spread blended = measure(&p);
        CHECK_EQUAL(covered, p.stats.covered_pixels);
        CHECK(plain.variance > 500 && blended.variance < plain.variance / 2);
        CHECK(fabs(blended.mean - plain.mean) < 8);
        made_picture_end(&p);
    }
}

// Two parallel sheets, one behind the other, and a perpendicular one, red and blue: each pixel is
// red or blue, or white where triangles are drawn.
void test_blend_keeps_surfaces_apart(test_state* test)
{
    static uint8_t plain[BYTES];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 1));
    made_picture_add(&p, 0.0, (stp_vec3d){0, 0, 0}, blue);
    made_picture_add(&p, 0.0, (stp_vec3d){0.7, 0.5, 0.5}, red);
    made_picture_add(&p, -0.5 * STP_PI, (stp_vec3d){0, -0.5, 1}, red);
    p.view.eye = (stp_vec3d){1, 2, 5};
    p.quality.splat_size = 4;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(p.stats.splats > 500);
    memcpy(plain, p.pixels, BYTES);
    p.style.filter = STP_FILTER_EWA;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    int mixed = 0, changed = 0;
    for (int i = 0; i < SIDE * SIDE; ++i) {
        const uint8_t* c = p.pixels + 4 * i;
        mixed += c[0] > 3 && c[2] > 3 && c[1] < 250 ? 1 : 0;
        changed += memcmp(c, plain + 4 * i, 4) != 0 ? 1 : 0;
        CHECK_EQUAL(plain[4 * i + 3], c[3]);
    }
    CHECK_EQUAL(0, mixed);
    CHECK(changed < 20); // each square has one colour: nothing to blend
    made_picture_end(&p);
}

// Triangles are not blended, and a pixel with more splats than its sums can hold stays unchanged.
void test_blend_leaves_triangles_and_crowds_alone(test_state* test)
{
    static uint8_t plain[BYTES];
    for (int variant = 0; variant < 2; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 1));
        made_picture_add(&p, 0.0, (stp_vec3d){0}, variant == 0 ? NULL : red);
        if (variant == 1) { // 4^7 splats in one pixel
            made_free_set(p.context, &p.scene.sets[0]);
            p.scene.sets[0] = made_square_set(p.context, 7, red);
            p.quality.splat_count = 16384;
            p.view.eye = (stp_vec3d){0.9, 0.9, 400};
            p.view.target = (stp_vec3d){0.9, 0.9, 0};
        } else {
            made_picture_add(&p, 0.0, (stp_vec3d){1, 0, -0.5}, blue);
            p.quality.splat_size = 4;
        }
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        memcpy(plain, p.pixels, BYTES);
        uint64_t covered = p.stats.covered_pixels;
        p.style.filter = STP_FILTER_EWA;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(variant == 1 ? p.stats.splats == 16384 && covered <= 4 : p.stats.splats > 100);
        CHECK_EQUAL(0, memcmp(plain, p.pixels, BYTES));
        made_picture_end(&p);
    }
}

static void make_rich(made_picture* p)
{
    made_picture_add(p, 0.4, (stp_vec3d){0}, red);
    made_picture_add(p, -0.9, (stp_vec3d){0.5, 0.2, 0.3}, blue);
    made_picture_add(p, 0.1, (stp_vec3d){-1, 0.5, 0.7}, NULL);
    make_noisy(p);
    memset(p->scene.sets[1].coverages, STP_COVERAGE_CHANCES - 7, p->scene.sets[1].count);
    p->scene.shadings[0].flags = 0;
    p->quality.splat_size = 4;
    p->style.filter = STP_FILTER_EWA;
    p->style.eye_dome = 1;
}

void test_blend_is_the_same_for_any_number_of_threads(test_state* test)
{
    static uint8_t first[2][BYTES];
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, threads));
        make_rich(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (uint32_t i = 0; i < 2; ++i) {
            p.style.supersample = 1 + i;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK(p.stats.splats > 500);
            if (threads == 1) {
                memcpy(first[i], p.pixels, BYTES);
            }
            CHECK_EQUAL(0, memcmp(first[i], p.pixels, BYTES));
        }
        made_picture_end(&p);
    }
}

void test_blend_allocates_nothing_in_warm_frames(test_state* test)
{
    static uint8_t first[BYTES];
    test_heap heap = TEST_HEAP(-1);
    made_picture p;
    CHECK(made_picture_begin(&p, &heap, 3));
    make_rich(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    memcpy(first, p.pixels, BYTES);
    p.style.filter = STP_FILTER_NONE;
    p.view.eye.x += 1.0; // a frame of two passes in between
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    p.style.filter = STP_FILTER_EWA;
    p.view.eye.x -= 1.0;
    int before = heap.count;
    for (int i = 0; i < 5; ++i) {
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, memcmp(first, p.pixels, BYTES));
    }
    CHECK_EQUAL(before, heap.count);
    made_picture_end(&p);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_blend_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_rich(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        heap.fail_at = heap.count + n;
        stp_result result = made_picture_draw(&p);
        heap.fail_at = -1;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(p.stats.covered_pixels > 300);
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            CHECK(n >= 8);
            break;
        }
    }
}
