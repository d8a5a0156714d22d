// SPDX-License-Identifier: MIT
// Cut-outs: every mip level of a texture keeps the share that level 0 keeps.
#include "tests.h"

#include "base/math/rng.h"
#include "raster/cutout.h"

#include <string.h>

enum { SIDE = 256 };

/// Alpha of three kinds of cut-outs: leaves (small disks), a lattice, and a smooth ramp.
static uint8_t alpha_of(int kind, uint32_t x, uint32_t y)
{
    if (kind == 2) {
        return (uint8_t)x;
    }
    if (kind == 1) {
        return x % 8 < 2 || y % 8 < 2 ? 255 : 0;
    }
    uint32_t cx = x / 16, cy = y / 16;
    int32_t dx = (int32_t)(x % 16) - 8, dy = (int32_t)(y % 16) - 8;
    int32_t reach = (int32_t)(stp_rng_hash(7, cy * 16 + cx) % 8), square = dx * dx + dy * dy;
    return square > reach * reach ? 0 : square < (reach - 1) * (reach - 1) ? 255 : 130;
}

static void make_pyramid(test_state* test, stp_context* context, int kind, uint8_t* texels,
                         stp_texture_pyramid* pyramid)
{
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        memset(texels + 4 * (size_t)i, 90, 3);
        texels[4 * (size_t)i + 3] = alpha_of(kind, i % SIDE, i / SIDE);
    }
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(context, texels, SIDE, SIDE, false, pyramid));
    CHECK_EQUAL(STP_OK, stp_cutout_prepare(context, pyramid));
}

/// The share of 128 x 128 pixels that is kept, at a footprint.
static double find_share(const stp_texture_pyramid* pyramid, float footprint, float own,
                         float cutoff)
{
    uint32_t left = 0;
    for (uint32_t i = 0; i < 128 * 128; ++i) {
        stp_vec2 uv = {((float)(i % 128) + 0.37f) / 128.0f, ((float)(i / 128) + 0.61f) / 128.0f};
        left += stp_cutout_keeps(pyramid, uv, footprint, own, cutoff);
    }
    return (double)left / (128.0 * 128.0);
}

void test_cutout_levels_keep_the_share_of_level_0(test_state* test)
{
    static const float cutoffs[] = {0.1f, 0.25f, 0.5f, 0.75f, 0.9f};
    stp_context* context = test_context(NULL, 1, NULL);
    uint8_t* texels = malloc(4 * SIDE * SIDE);
    for (int kind = 0; kind < 3; ++kind) {
        stp_texture_pyramid pyramid;
        make_pyramid(test, context, kind, texels, &pyramid);
        for (int c = 0; c < 5; ++c) {
            double whole = find_share(&pyramid, 1.0f, 1.0f, cutoffs[c]);
            double own = find_share(&pyramid, 1.0f, 0.8f, cutoffs[c]); // a cutoff of the material's
            for (float footprint = 2.0f; footprint <= 256.0f; footprint *= 2.0f) {
                double apart = 0.03; // a fiftieth, and the error of 128 x 128 pixels
                CHECK(fabs(find_share(&pyramid, footprint, 1.0f, cutoffs[c]) - whole) < apart);
                CHECK(fabs(find_share(&pyramid, footprint, 0.8f, cutoffs[c]) - own) < apart);
            }
        }
        stp_texture_pyramid_destroy(context, &pyramid);
    }
    free(texels);
    stp_context_destroy(context);
}

void test_cutout_of_a_ramp_is_a_hard_edge_at_any_distance(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    uint8_t* texels = malloc(4 * SIDE * SIDE);
    stp_texture_pyramid pyramid;
    make_pyramid(test, context, 2, texels, &pyramid);
    for (float footprint = 1.0f; footprint <= 16.0f; footprint *= 2.0f) {
        uint32_t changes = 0;
        bool before = false;
        for (uint32_t x = 0; x < 100; ++x) { // wrapping blends the borders with each other
            bool there = stp_cutout_keeps(
                &pyramid, (stp_vec2){0.1f + 0.8f * (float)x / 100.0f, 0.5f}, footprint, 1.0f, 0.4f);
            changes += x > 0 && there != before;
            before = there;
        }
        CHECK_EQUAL(1, changes);
        CHECK(before);
    }
    stp_texture_pyramid_destroy(context, &pyramid);
    free(texels);
    stp_context_destroy(context);
}

void test_cutout_above_the_material_leaves_nothing(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    uint8_t* texels = malloc(4 * SIDE * SIDE);
    stp_texture_pyramid pyramid;
    make_pyramid(test, context, 1, texels, &pyramid);
    for (float footprint = 1.0f; footprint <= 64.0f; footprint *= 2.0f) {
        CHECK_EQUAL(0, (int)(1e6 * find_share(&pyramid, footprint, 0.5f, 0.6f)));
        CHECK_EQUAL(0, (int)(1e6 * find_share(&pyramid, footprint, 0.0f, 0.6f)));
        CHECK_EQUAL(1000000, (int)(1e6 * find_share(&pyramid, footprint, 0.0f, 0.0f)));
    }
    stp_texture_pyramid_destroy(context, &pyramid);
    free(texels);
    stp_context_destroy(context);
}

void test_cutout_preparing_reports_missing_memory(test_state* test)
{
    uint8_t* texels = malloc(4 * SIDE * SIDE);
    for (int fail = 0; fail < 3; ++fail) {
        test_heap heap = TEST_HEAP(-1);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_texture_pyramid pyramid;
        CHECK_EQUAL(STP_OK,
                    stp_texture_pyramid_create(context, texels, SIDE, SIDE, false, &pyramid));
        heap.fail_at = heap.count + fail;
        stp_result result = stp_cutout_prepare(context, &pyramid);
        CHECK(fail < 2 ? result == STP_ERROR_OUT_OF_MEMORY : result == STP_OK);
        stp_texture_pyramid_destroy(context, &pyramid);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    free(texels);
}
