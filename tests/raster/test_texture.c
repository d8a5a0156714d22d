// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/color.h"
#include "base/math/rng.h"
#include "raster/texture.h"

#include <string.h>

static void fill(uint8_t* texels, size_t count, uint8_t r, uint8_t g, uint8_t b, uint8_t a)
{
    for (size_t i = 0; i < count; ++i) {
        memcpy(texels + 4 * i, (uint8_t[4]){r, g, b, a}, 4);
    }
}

void test_texture_averages_in_linear_light(test_state* test)
{
    // black and white halves average to linear 1/2, which is 188 in sRGB; 128 if the bytes are
    // linear
    uint8_t texels[8 * 8 * 4];
    for (size_t i = 0; i < 64; ++i) {
        fill(texels + 4 * i, 1, i % 2 ? 255 : 0, i % 2 ? 255 : 0, 255, 255);
    }
    stp_context* context = test_context(NULL, 2, NULL);
    for (int linear = 0; linear < 2; ++linear) {
        stp_texture_pyramid pyramid;
        CHECK_EQUAL(STP_OK,
                    stp_texture_pyramid_create(context, texels, 8, 8, linear != 0, &pyramid));
        CHECK_EQUAL(4, pyramid.level_count);
        CHECK_EQUAL(1, pyramid.width[3]);
        for (uint32_t level = 1; level < 4; ++level) {
            CHECK_EQUAL(linear ? 128 : 188, pyramid.texels[level][0]);
            CHECK_EQUAL(255, pyramid.texels[level][2]);
            CHECK_EQUAL(255, pyramid.texels[level][3]);
        }
        stp_texture_pyramid_destroy(context, &pyramid);
    }
    stp_context_destroy(context);
}

void test_texture_odd_sizes_count_every_texel_alike(test_state* test)
{
    // one red texel anywhere in 5 x 3: the last level's red is the same 1/15
    stp_context* context = test_context(NULL, 1, NULL);
    for (size_t place = 0; place < 15; ++place) {
        uint8_t texels[15 * 4];
        fill(texels, 15, 0, 0, 0, 255);
        texels[4 * place] = 255;
        stp_texture_pyramid pyramid;
        CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(context, texels, 5, 3, true, &pyramid));
        CHECK_EQUAL(3, pyramid.level_count);
        CHECK_EQUAL(2, pyramid.width[1]);
        CHECK_EQUAL(1, pyramid.height[1]);
        CHECK(pyramid.texels[2][0] >= 16 && pyramid.texels[2][0] <= 18);
        stp_texture_pyramid_destroy(context, &pyramid);
    }
    stp_context_destroy(context);
}

void test_texture_cutout_borders_do_not_bleed(test_state* test)
{
    // green leaves on transparent black keep their green in every level
    uint8_t texels[16 * 16 * 4];
    for (size_t i = 0; i < 256; ++i) {
        bool leaf = stp_rng_hash(1, i) % 3 == 0;
        fill(texels + 4 * i, 1, 0, leaf ? 200 : 0, 0, leaf ? 255 : 0);
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_texture_pyramid pyramid;
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(context, texels, 16, 16, false, &pyramid));
    CHECK(abs((int)pyramid.texels[4][1] - 200) <= 1);
    CHECK(pyramid.texels[4][3] > 60 && pyramid.texels[4][3] < 110);
    float color[4];
    for (uint64_t i = 0; i < 100; ++i) {
        stp_vec2 uv = {(float)(stp_rng_hash(2, i) % 1000) / 1000.0f,
                       (float)(stp_rng_hash(3, i) % 1000) / 1000.0f};
        stp_texture_sample(&pyramid, uv, (float)i * 0.2f, color);
        CHECK(color[3] <= 0.0f || fabsf(color[1] - stp_srgb8_to_linear(200)) < 0.01f);
    }
    stp_texture_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

void test_texture_wraps(test_state* test)
{
    uint8_t texels[4 * 4];
    for (int i = 0; i < 4; ++i) {
        fill(texels + 4 * i, 1, (uint8_t)(i * 50), 0, 0, 255);
    }
    stp_context* context = test_context(NULL, 1, NULL);
    stp_texture_pyramid pyramid;
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(context, texels, 4, 1, true, &pyramid));
    static const struct {
        stp_texture_wrap wrap;
        float u;
        int texel;
    } cases[] = {
        {STP_TEXTURE_REPEAT, 0.125f, 0},  {STP_TEXTURE_REPEAT, 1.375f, 1},
        {STP_TEXTURE_REPEAT, -0.125f, 3}, {STP_TEXTURE_REPEAT, -7.625f, 1},
        {STP_TEXTURE_CLAMP, -5.0f, 0},    {STP_TEXTURE_CLAMP, 5.0f, 3},
        {STP_TEXTURE_MIRROR, 1.125f, 3},  {STP_TEXTURE_MIRROR, -0.375f, 1},
        {STP_TEXTURE_MIRROR, 2.375f, 1},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        for (int nearest = 0; nearest < 2; ++nearest) {
            pyramid.wrap_u = pyramid.wrap_v = cases[i].wrap;
            pyramid.nearest = nearest != 0;
            float color[4];
            stp_texture_sample(&pyramid, (stp_vec2){cases[i].u, 0.5f}, 0.0f, color);
            CHECK(fabsf(color[0] * 255.0f - (float)cases[i].texel * 50.0f) < 0.01f);
        }
    }
    float color[4]; // halfway between texels 1 and 2; and across the seam, between 3 and 0
    pyramid.wrap_u = STP_TEXTURE_REPEAT;
    pyramid.nearest = false;
    stp_texture_sample(&pyramid, (stp_vec2){0.5f, 0.5f}, 1.0f, color);
    CHECK(fabsf(color[0] * 255.0f - 75.0f) < 0.01f);
    stp_texture_sample(&pyramid, (stp_vec2){1.0f, 0.5f}, 1.0f, color);
    CHECK(fabsf(color[0] * 255.0f - 75.0f) < 0.01f);
    static const float odd[] = {NAN, INFINITY, -INFINITY, 1e30f, -3e9f};
    for (size_t i = 0; i < 5; ++i) {
        stp_texture_sample(&pyramid, (stp_vec2){odd[i], odd[i]}, odd[i], color);
        CHECK(color[0] >= 0.0f && color[0] <= 1.0f && color[3] >= 0.0f && color[3] <= 1.0f);
    }
    stp_texture_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

void test_texture_footprint_chooses_the_level(test_state* test)
{
    // each level has its own shade
    uint8_t texels[64 * 4];
    fill(texels, 64, 0, 0, 0, 255);
    stp_context* context = test_context(NULL, 1, NULL);
    stp_texture_pyramid pyramid;
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(context, texels, 8, 8, true, &pyramid));
    for (uint32_t level = 1; level < 4; ++level) {
        size_t start = (size_t)(pyramid.texels[level] - pyramid.owned);
        fill(pyramid.owned + start, (size_t)pyramid.width[level] * pyramid.height[level],
             (uint8_t)(level * 50), 0, 0, 255);
    }
    static const float footprints[] = {0.0f, 1.0f, 1.5f, 2.0f, 3.0f, 4.0f, 6.0f, 8.0f, 1000.0f};
    static const float shades[] = {0.0f, 0.0f, 25.0f, 50.0f, 75.0f, 100.0f, 125.0f, 150.0f, 150.0f};
    for (size_t i = 0; i < 9; ++i) {
        float color[4];
        stp_texture_sample(&pyramid, (stp_vec2){0.4f, 0.6f}, footprints[i], color);
        CHECK(fabsf(color[0] * 255.0f - shades[i]) < 0.01f);
    }
    stp_texture_pyramid_destroy(context, &pyramid);
    stp_context_destroy(context);
}

void test_texture_pyramid_is_the_same_for_any_thread_count(test_state* test)
{
    enum { WIDTH = 77, HEIGHT = 130 };
    static uint8_t texels[WIDTH * HEIGHT * 4];
    for (size_t i = 0; i < sizeof(texels); ++i) {
        texels[i] = (uint8_t)stp_rng_hash(4, i);
    }
    stp_context* one = test_context(NULL, 1, NULL);
    stp_context* three = test_context(NULL, 3, NULL);
    stp_texture_pyramid a, b;
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(one, texels, WIDTH, HEIGHT, false, &a));
    CHECK_EQUAL(STP_OK, stp_texture_pyramid_create(three, texels, WIDTH, HEIGHT, false, &b));
    for (uint32_t level = 1; level < a.level_count; ++level) {
        CHECK(memcmp(a.texels[level], b.texels[level],
                     (size_t)a.width[level] * a.height[level] * 4) == 0);
    }
    stp_texture_pyramid_destroy(one, &a);
    stp_texture_pyramid_destroy(three, &b);
    stp_context_destroy(one);
    stp_context_destroy(three);
}

void test_texture_survives_failing_allocator(test_state* test)
{
    uint8_t texels[4 * 4 * 4] = {0};
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context == NULL) {
            continue;
        }
        stp_texture_pyramid pyramid;
        stp_result result = stp_texture_pyramid_create(context, texels, 4, 4, false, &pyramid);
        stp_texture_pyramid_destroy(context, &pyramid);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            return;
        }
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
    }
}
