// SPDX-License-Identifier: MIT
// Frames of a resting view: their mean is the supersampled picture.
#include "support_picture.h"
#include "tests.h"

#include "draw/cpu/passes.h"
#include "draw/renderer.h"

#include <string.h>

enum { SIDE = PICTURE_SIDE };

static const uint8_t orange[3] = {230, 120, 30};

static void make_scene(made_picture* p)
{
    made_picture_add(p, 0.2, (stp_vec3d){0, 0.3, 0}, orange);
    made_picture_add(p, 0.9, (stp_vec3d){-0.7, 0, 0.4}, NULL);
    p->scene.materials[0].alpha = STP_STORE_BLEND; // its dither equals that of the sample
    p->scene.materials[0].base_color[3] = 0.6f;
    p->view.eye = (stp_vec3d){1, 2, 5};
    p->quality.splat_size = 2;
    p->style.supersample = 4;
}

void test_accumulation_takes_every_place_once(test_state* test)
{
    for (uint32_t side = 1; side <= 64; ++side) {
        static uint8_t seen[64 * 64];
        memset(seen, 0, sizeof(seen));
        for (uint32_t k = 0; k < side * side; ++k) {
            uint32_t place = stp_resting_sample(side, k);
            CHECK(place < side * side && seen[place] == 0);
            seen[place] = 1;
        }
    }
}

static int largest_difference(const uint8_t* a, const uint8_t* b)
{
    int maximum = 0;
    for (int i = 0; i < SIDE * SIDE * 4; ++i) {
        int difference = abs(a[i] - b[i]);
        maximum = difference > maximum ? difference : maximum;
    }
    return maximum;
}

// Each frame is rounded to bytes, so the mean of a dark pixel may differ by a level or two.
void test_accumulation_becomes_the_supersampled_picture(test_state* test)
{
    static uint8_t whole[SIDE * SIDE * 4];
    for (int variant = 0; variant < 4; ++variant) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, 1 + (uint32_t)variant % 3));
        make_scene(&p);
        p.style.background = variant % 2 == 1;
        p.style.background_color[1] = 90;
        p.view.ortho_height = variant >= 2 ? 4 : 0;
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        CHECK_EQUAL(STP_OK, made_picture_draw(&p));
        CHECK_EQUAL(16, p.stats.samples);
        memcpy(whole, p.pixels, sizeof(whole));
        uint64_t covered = p.stats.covered_pixels;
        int first = 0;
        for (uint32_t i = 1; i <= 16; ++i) {
            CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
            CHECK_EQUAL(i, p.stats.samples);
            first = i == 1 ? largest_difference(whole, p.pixels) : first;
        }
        CHECK(first > 40);
        CHECK(largest_difference(whole, p.pixels) <= 2);
        CHECK_EQUAL(covered, p.stats.covered_pixels);
        memcpy(whole, p.pixels, sizeof(whole));
        memset(p.pixels, 0, sizeof(whole));
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p)); // nothing is left to draw
        CHECK_EQUAL(16, p.stats.samples);
        CHECK_EQUAL(0, p.stats.fragments);
        CHECK_EQUAL(0, memcmp(whole, p.pixels, sizeof(whole)));
        made_picture_end(&p);
    }
}

// With effects, supersampling is accumulation.
void test_accumulation_goes_with_effects(test_state* test)
{
    static uint8_t whole[SIDE * SIDE * 4];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_scene(&p);
    p.style.eye_dome = 1;
    p.style.ambient_occlusion = 0.05f;
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    memcpy(whole, p.pixels, sizeof(whole));
    for (uint32_t i = 1; i <= 16; ++i) {
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
        CHECK_EQUAL(i, p.stats.samples);
    }
    CHECK_EQUAL(0, memcmp(whole, p.pixels, sizeof(whole)));
    made_picture_end(&p);
}

void test_accumulation_restarts_after_a_change(test_state* test)
{
    static uint8_t first[SIDE * SIDE * 4];
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    make_scene(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    for (int change = 0; change < 9; ++change) {
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
        CHECK_EQUAL(1, p.stats.samples);
        memcpy(first, p.pixels, sizeof(first));
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
        CHECK_EQUAL(2, p.stats.samples);
        CHECK(largest_difference(first, p.pixels) > 0);
        p.view.eye.x += change == 0 ? 0.5 : 0.0;
        p.view.target.y += change == 1 ? 0.5 : 0.0;
        p.view.fov_degrees += change == 2 ? 3.0 : 0.0;
        p.quality.splat_size += change == 3 ? 2.0f : 0.0f;
        p.quality.reference = change == 4;
        p.style.headlight = change == 5;
        p.style.background = change == 6;
        p.style.supersample += change == 7 ? 1 : 0;
    }
    made_picture other = p; // a supersampled picture in between changes nothing
    other.style.supersample = 2;
    other.style.transparency = STP_TRANSPARENCY_PATTERN; // layers need the sums
    static uint8_t pixels[SIDE * SIDE * 4];
    other.image.pixels = pixels;
    other.list = (stp_draw_list){0};
    CHECK_EQUAL(STP_OK, made_picture_draw(&other));
    CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
    CHECK_EQUAL(3, p.stats.samples);
    other.style.eye_dome = 1; // but a change that needs the sums does
    CHECK_EQUAL(STP_OK, made_picture_draw(&other));
    CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
    CHECK_EQUAL(1, p.stats.samples);
    stp_draw_list_destroy(p.context, &other.list);
    made_picture_end(&p);
}

void test_accumulation_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(-1);
        made_picture p;
        CHECK(made_picture_begin(&p, &heap, 2));
        make_scene(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        heap.fail_at = heap.count + n;
        stp_result result = made_picture_accumulate(&p);
        heap.fail_at = -1;
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        CHECK_EQUAL(STP_OK, made_picture_accumulate(&p));
        CHECK_EQUAL(result == STP_OK ? 2 : 1, p.stats.samples);
        CHECK(p.stats.covered_pixels > 300);
        made_picture_end(&p);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            CHECK(n >= 8);
            break;
        }
    }
}

// What a picture depends on ends the rest; the same list again does not.
void test_accumulation_ends_with_every_change_of_an_item(test_state* test)
{
    stp_draw_item item = {.kind = STP_DRAW_SPLATS, .prefix = 64, .full_prefix = 64, .radius = 1};
    stp_draw_list list = {.items = &item, .count = 1, .splat_size = 2};
    stp_view view = {.eye = {1, 2, 5}, .up = {0, 1, 0}, .fov_degrees = 60, .width = 8, .height = 8};
    stp_draw_style style = {0};
    stp_resting resting = {0};
    (void)stp_resting_continues(&resting, &view, &list, &style);
    CHECK(stp_resting_continues(&resting, &view, &list, &style));
#define CHANGED(member, value)                                                                     \
    {                                                                                              \
        stp_draw_item before = item;                                                               \
        item.member = value;                                                                       \
        CHECK(!stp_resting_continues(&resting, &view, &list, &style));                             \
        CHECK(stp_resting_continues(&resting, &view, &list, &style));                              \
        item = before;                                                                             \
        CHECK(!stp_resting_continues(&resting, &view, &list, &style));                             \
    }
    CHANGED(kind, STP_DRAW_MESH)
    CHANGED(index, 1)
    CHANGED(prefix, 32)
    CHANGED(full_prefix, 128)
    CHANGED(radius, 2)
    CHANGED(level_per_depth, 1)
    CHANGED(level_min, 1)
    CHANGED(divide, 1)
    CHANGED(level_below, 1)
    CHANGED(split_count, 1)
    CHANGED(shape_scale, 2)
    CHANGED(scattered, true)
    CHANGED(large, true)
    CHANGED(large_from, 1)
    CHANGED(beside_triangles, true)
    CHANGED(switch_begin, 1)
    CHANGED(switch_end, 1)
    CHANGED(sections, 1)
    CHANGED(ghost, true)
    CHANGED(one_sided, true)
    CHANGED(of_points, true)
    CHANGED(transform.m[1][3], 1)
#undef CHANGED
}
