// SPDX-License-Identifier: MIT
// Eye-dome lighting and ambient occlusion: which pixels are darkened, and which are not.
#include "support_picture.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "draw/cpu/effects.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE, ROW = 173, PAD = 32 };

static const uint8_t grey[3] = {200, 200, 200};

static float dice(uint64_t* state)
{
    return (float)(stp_rng_hash(7, (*state)++) >> 40) * (1.0f / 16777216.0f);
}

typedef struct rows {
    float center[ROW], gain[ROW], near[2][ROW + 2 * PAD], values[ROW + 2 * PAD];
    float out[9][ROW];
} rows;

// All kernels, applied to random rows.
static void run_kernels(const stp_cpu_effect_kernels* k, rows* r)
{
    uint64_t state = 0;
    for (int i = 0; i < ROW + 2 * PAD; ++i) {
        r->near[0][i] = dice(&state) < 0.1f ? -1.0f : dice(&state);
        r->near[1][i] = dice(&state) < 0.1f ? 0.0f : dice(&state);
        r->values[i] = dice(&state);
    }
    for (int i = 0; i < ROW; ++i) {
        r->center[i] = i % 7 == 0 ? 0.0f : dice(&state);
    }
    memset(r->out, 0, sizeof(r->out));
    const float* const pair[2] = {r->near[0] + PAD - 3, r->near[1] + PAD + 5};
    k->gain(r->center, 900.0f, false, r->gain, ROW);
    memcpy(r->out[0], r->gain, sizeof(r->gain));
    k->gain(r->center, 900.0f, true, r->out[1], ROW);
    k->rise(r->center, r->gain, pair, 0.3f, r->out[2], ROW);
    memcpy(r->out[3], r->out[2], sizeof(r->out[2]));
    k->eye_dome(r->out[3], 0.7f, ROW);
    const float numbers[3] = {0.1f, 0.05f, 1.0f / 700.0f};
    k->pair(r->center, r->gain, pair, numbers, r->out[4], ROW);
    float* const sums[2] = {r->out[5], r->out[6]};
    k->blur(r->center, r->gain, pair[0], r->values + PAD, 0.01f, sums, ROW);
    k->greatest(r->near[0] + PAD, 3, r->out[7], ROW);
    float mixed[ROW];
    k->spread(pair, 0.375f, mixed, (ROW + 7) / 8, r->out[8], ROW);
}

void test_effect_kernels_agree(test_state* test)
{
    static rows expected, got;
    run_kernels(&stp_cpu_effect_kernels_portable, &expected);
    for (int i = 0; i < ROW; ++i) { // against the expected values
        float maximum = -2.0f, minimum = 2.0f, found;
        for (int k = -3; k <= 3; ++k) {
            float v = expected.near[0][PAD + i + k];
            maximum = v > maximum ? v : maximum;
            minimum = v < minimum ? v : minimum;
        }
        CHECK(expected.out[7][i] == maximum);
        stp_cpu_effect_kernels_portable.minimum(expected.near[0] + PAD + i, 3, &found, 1);
        CHECK(found == minimum);
        CHECK(expected.out[3][i] > 0.0f && expected.out[3][i] <= 1.0f);
        CHECK(expected.out[4][i] >= 0.0f && expected.out[4][i] <= 1.0f);
    }
    if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
        run_kernels(&STP_VECTOR(stp_cpu_effect_kernels), &got);
        CHECK_EQUAL(0, memcmp(expected.out, got.out, sizeof(got.out)));
    }
    if (stp_processor_detect() >= STP_PROCESSOR_WIDE) {
        run_kernels(&STP_WIDE(stp_cpu_effect_kernels), &got);
        CHECK_EQUAL(0, memcmp(expected.out, got.out, sizeof(got.out)));
    }
}

static void set_parallel(made_picture* p)
{
    p->view.fov_degrees = 0;
    p->view.ortho_height = 4;
}

static int brightness(const made_picture* p, int x, int y)
{
    const uint8_t* at = made_picture_pixel(p, x, y);
    return at[3] == 0 ? -1 : at[0];
}

// A plane does not occlude itself at any angle, and its slope darkens it less than a step does.
void test_effects_leave_planes_alone(test_state* test)
{
    for (int variant = 0; variant < 4; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 1));
        if (variant % 2 == 1) {
            set_parallel(&p);
        }
        made_picture_add(&p, variant >= 2 ? 1.3 : 0.4, (stp_vec3d){0, 0, 0}, NULL);
        p.style.ambient_occlusion = 0.08f;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(p.stats.covered_pixels > 200);
        for (int i = 0; i < SIDE * SIDE; ++i) {
            int b = brightness(&p, i % SIDE, i / SIDE);
            CHECK(b == -1 || b == 255);
        }
        p.style = (stp_draw_style){.eye_dome = 1};
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        for (int i = 0; i < SIDE * SIDE; ++i) {
            int b = brightness(&p, i % SIDE, i / SIDE);
            CHECK(b == -1 || b > 180);
        }
        made_picture_end(&p);
    }
}

// Where a wall meets a floor both are darker than elsewhere; content in front of them is unchanged.
void test_ambient_occlusion_darkens_corners(test_state* test)
{
    for (int variant = 0; variant < 4; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 2));
        if (variant % 2 == 1) {
            set_parallel(&p);
        }
        const uint8_t* color = variant >= 2 ? grey : NULL;
        made_picture_add(&p, 0.0, (stp_vec3d){0, 1, 0}, color);
        made_picture_add(&p, -0.5 * STP_PI, (stp_vec3d){0, 0, 1}, color);
        p.view.eye = (stp_vec3d){0, 4, 5};
        p.style.ambient_occlusion = 0.08f;
        p.quality.splat_size = 4;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK((p.stats.splats > 0) == (variant >= 2));
        int corner = 0, away = 0, wall = 0;
        for (int x = 28; x < 36; ++x) {
            int darkest = 255, last = 0;
            for (int y = 0; y < SIDE; ++y) {
                int b = brightness(&p, x, y);
                darkest = b >= 0 && b < darkest ? b : darkest;
                last = b >= 0 ? b : last;
            }
            corner += darkest;
            away += last;
            wall += brightness(&p, x, 22);
        }
        CHECK(corner < away * (color != NULL ? 97 : 80) / 100 && corner > away / 4);
        CHECK(wall > corner && away / 8 >= (color != NULL ? 190 : 250));
        made_picture_end(&p);
    }
}

// A surface behind an edge is darkened along it; the edge itself, distant pixels and the background
// are not.
void test_eye_dome_darkens_behind_edges(test_state* test)
{
    for (int variant = 0; variant < 2; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 1));
        if (variant == 1) {
            set_parallel(&p);
        }
        made_picture_add(&p, 0.0, (stp_vec3d){0, 0, 0}, NULL);
        made_picture_add(&p, 0.0, (stp_vec3d){-1, 0, 1}, NULL);
        p.style.eye_dome = 1;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        int edge = 32; // edge of the front square: the first pixel behind it
        CHECK_EQUAL(255, brightness(&p, edge - 3, 32));
        CHECK_EQUAL(255, brightness(&p, edge - 1, 32));
        CHECK(brightness(&p, edge, 32) < 200);
        CHECK_EQUAL(255, brightness(&p, edge + 6, 32));
        CHECK_EQUAL(-1, brightness(&p, 60, 32));
        int weak = brightness(&p, edge, 32);
        p.style.eye_dome = 4;
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK(brightness(&p, edge, 32) < weak);
        made_picture_end(&p);
    }
}

static void make_corner(made_picture* p)
{
    made_picture_add(p, 0.0, (stp_vec3d){0, 1, 0}, grey);
    made_picture_add(p, -0.5 * STP_PI, (stp_vec3d){0, 0, 1}, grey);
    made_picture_add(p, 0.3, (stp_vec3d){-1, 0.5, 0.7}, NULL);
    p->view.eye = (stp_vec3d){1, 4, 5};
    p->quality.splat_size = 3;
    p->style.ambient_occlusion = 0.5f; // beyond the reach of single pixels: uses the pyramid too
    p->style.eye_dome = 1;
}

void test_effects_are_the_same_for_any_number_of_threads(test_state* test)
{
    static uint8_t first[2][SIDE * SIDE * 4];
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, threads));
        make_corner(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (uint32_t i = 0; i < 2; ++i) {
            p.style.supersample = 1 + i;
            CHECK_EQUAL(STP_OK, made_picture_draw(&p));
            CHECK(p.stats.covered_pixels > 400 && p.stats.samples == (1 + i) * (1 + i));
            if (threads == 1) {
                memcpy(first[i], p.pixels, sizeof(first[i]));
            }
            CHECK_EQUAL(0, memcmp(first[i], p.pixels, sizeof(first[i])));
        }
        made_picture_end(&p);
    }
}

// Consecutive frames, and frames after pictures of other sizes and kinds.
void test_effects_remember_nothing(test_state* test)
{
    static uint8_t first[SIDE * SIDE * 4], small[24 * 24 * 4];
    test_heap heap = TEST_HEAP(-1);
    made_picture p;
    CHECK(made_picture_begin(&p, &heap, 2));
    make_corner(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    memcpy(first, p.pixels, sizeof(first));
    made_picture other = p;
    other.view.width = other.view.height = 24;
    other.image = (stp_image){24, 24, small};
    other.list = (stp_draw_list){0};
    for (int i = 0; i < 4; ++i) {
        other.style.ambient_occlusion = i % 2 == 0 ? 0.05f : 0.0f;
        other.view.ortho_height = i >= 2 ? 4 : 0;
        CHECK_EQUAL(STP_OK, made_picture_draw(&other));
    }
    stp_draw_list_destroy(p.context, &other.list);
    int before = heap.count;
    for (int i = 0; i < 5; ++i) {
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(0, memcmp(first, p.pixels, sizeof(first)));
    }
    CHECK_EQUAL(before, heap.count); // a warm frame allocates nothing
    made_picture_end(&p);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_effects_survive_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_corner(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        p.view.ortho_height = n % 2 == 0 ? 0 : 4;
        heap.fail_at = heap.count + n / 2;
        p.style.supersample = 2;
        stp_result result = made_picture_draw(&p);
        heap.fail_at = -1;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(STP_OK, made_picture_draw(&p)); // after a failure the next frame is correct
        CHECK(p.stats.covered_pixels > 300 && p.stats.samples == 4);
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            CHECK(n >= 16);
            break;
        }
    }
}
