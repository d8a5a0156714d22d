// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/measure/image_compare.h"

#include <math.h>
#include <string.h>

enum { WIDTH = 203, HEIGHT = 171, PIXELS = WIDTH * HEIGHT };

static uint32_t mix(uint32_t value)
{
    value *= 2654435761U;
    value ^= value >> 15;
    value *= 2246822519U;
    return value ^ value >> 13;
}

static int square(int x)
{
    return x * x;
}

static uint8_t to_byte(int value)
{
    return (uint8_t)(value < 0 ? 0 : value > 255 ? 255 : value);
}

// The same formulas as in scripts/make_ssim_values.py.
static void fill_pattern(uint8_t* pixels, int is_second)
{
    for (int i = 0; i < PIXELS; ++i) {
        int x = i % WIDTH, y = i / WIDTH;
        int u = x + (is_second && x > 120), v = y;
        int noise = is_second ? (int)(mix((uint32_t)i) % 41) - 20 : 0;
        pixels[4 * i + 0] = to_byte((u * u / 40 + v * 3) % 256 + noise);
        pixels[4 * i + 1] = to_byte(40 + 170 * ((u / 9 + v / 7) % 2) + noise);
        pixels[4 * i + 2] = to_byte(abs((u * 5 + v * 2) % 510 - 255) + noise);
        pixels[4 * i + 3] = square(x - 60) + square(y - 90) < 900 ? 0 : 255;
        if (is_second && square(x - 64) + square(y - 90) < 1100) {
            pixels[4 * i + 3] = 128;
        }
    }
}

static stp_image make_pattern(int is_second)
{
    uint8_t* pixels = malloc((size_t)PIXELS * 4);
    if (pixels != NULL) {
        fill_pattern(pixels, is_second);
    }
    return (stp_image){.width = WIDTH, .height = HEIGHT, .pixels = pixels};
}

static int is_near(double expected, double actual, double tolerance)
{
    int near = fabs(expected - actual) <= tolerance;
    if (!near) {
        fprintf(stderr, "expected %.15g, got %.15g\n", expected, actual);
    }
    return near;
}

static int is_same(const stp_image_quality* a, const stp_image_quality* b)
{
    return memcmp(a, b, sizeof(*a)) == 0;
}

void test_image_compare_agrees_with_scikit_image(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_image a = make_pattern(0), b = make_pattern(1);
    stp_image_quality quality;
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, NULL, &quality));
    // printed by scripts/make_ssim_values.py (scikit-image 0.19.3, SciPy 1.10.1)
    CHECK(is_near(0.736942169738604, quality.ssim, 1e-12));
    CHECK(is_near(0.836988668141988, quality.ms_ssim, 1e-8)); // 2 x 2 averages are floats
    CHECK(is_near(16.488822777826, quality.psnr, 1e-10));
    free(a.pixels);
    free(b.pixels);
    stp_context_destroy(context);
}

static long double grey_of(const stp_image* image, int64_t x, int64_t y)
{
    const uint8_t* p = image->pixels + 4 * (y * (int64_t)image->width + x);
    long double grey = 0;
    static const long double weights[] = {0.299L, 0.587L, 0.114L};
    for (int c = 0; c < 3; ++c) {
        grey += weights[c] * (long double)((p[c] * p[3] + 127) / 255);
    }
    return grey;
}

// SSIM of one pixel straight from its definition: a two-dimensional window, clipped at the border.
static long double slow_ssim(const stp_image* a, const stp_image* b, int64_t cx, int64_t cy)
{
    long double weight = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
    for (int pass = 0; pass < 2; ++pass) {
        for (int64_t y = cy - 5; y <= cy + 5; ++y) {
            for (int64_t x = cx - 5; x <= cx + 5; ++x) {
                if (x < 0 || y < 0 || x >= (int64_t)a->width || y >= (int64_t)a->height) {
                    continue;
                }
                long double distance2 = (long double)((x - cx) * (x - cx) + (y - cy) * (y - cy));
                long double w = expl(-distance2 / (2 * 1.5L * 1.5L));
                long double ga = grey_of(a, x, y), gb = grey_of(b, x, y);
                if (pass == 0) {
                    weight += w;
                    ma += w * ga;
                    mb += w * gb;
                } else {
                    va += w * (ga - ma) * (ga - ma);
                    vb += w * (gb - mb) * (gb - mb);
                    cov += w * (ga - ma) * (gb - mb);
                }
            }
        }
        if (pass == 0) {
            ma /= weight;
            mb /= weight;
        }
    }
    long double c1 = square(255) * 0.0001L, c2 = square(255) * 0.0009L;
    return (2 * ma * mb + c1) * (2 * cov / weight + c2) /
           ((ma * ma + mb * mb + c1) * ((va + vb) / weight + c2));
}

// A part of the pattern, for pictures of any size.
static stp_image crop(const stp_image* image, uint32_t x0, uint32_t y0, uint32_t width,
                      uint32_t height)
{
    stp_image part = {
        .width = width, .height = height, .pixels = malloc((size_t)width * height * 4)};
    for (uint32_t y = 0; part.pixels != NULL && y < height; ++y) {
        memcpy(part.pixels + (size_t)y * width * 4,
               image->pixels + ((size_t)(y0 + y) * image->width + x0) * 4, (size_t)width * 4);
    }
    return part;
}

void test_image_compare_agrees_with_the_definition(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_image whole_a = make_pattern(0), whole_b = make_pattern(1);
    static const uint32_t sizes[][2] = {{1, 1}, {3, 40}, {10, 10}, {11, 11}, {12, 10}, {47, 80}};
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        uint32_t width = sizes[i][0], height = sizes[i][1];
        stp_image a = crop(&whole_a, 70, 60, width, height),
                  b = crop(&whole_b, 70, 60, width, height);
        long double all = 0, whole = 0, covered = 0;
        uint32_t whole_count = 0, covered_count = 0;
        stp_image map;
        stp_image_quality quality;
        CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, &map, &quality));
        CHECK_EQUAL(width, map.width);
        CHECK_EQUAL(height, map.height);
        for (uint32_t y = 0; y < height; ++y) {
            for (uint32_t x = 0; x < width; ++x) {
                size_t at = 4 * ((size_t)y * width + x);
                long double value = slow_ssim(&a, &b, x, y);
                CHECK(
                    is_near((double)(value > 0 ? value * 255 : 0), (double)map.pixels[at], 0.501));
                CHECK(map.pixels[at] == map.pixels[at + 1] && map.pixels[at] == map.pixels[at + 2]);
                CHECK_EQUAL(255, map.pixels[at + 3]);
                all += value;
                if (x >= 5 && y >= 5 && x + 5 < width && y + 5 < height) {
                    whole += value;
                    whole_count += 1;
                }
                if (a.pixels[at + 3] != 0 || b.pixels[at + 3] != 0) {
                    covered += value;
                    covered_count += 1;
                }
            }
        }
        long double expected = whole_count != 0 ? whole / whole_count : all / (width * height);
        CHECK(is_near((double)expected, quality.ssim, 1e-11));
        CHECK(is_near(covered_count != 0 ? (double)(covered / covered_count) : 1.0,
                      quality.ssim_covered, 1e-11));
        stp_free(context, map.pixels);
        free(a.pixels);
        free(b.pixels);
    }
    free(whole_a.pixels);
    free(whole_b.pixels);
    stp_context_destroy(context);
}

void test_image_compare_of_equal_pictures_is_perfect(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_image a = make_pattern(1);
    stp_image_quality quality;
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &a, NULL, NULL, &quality));
    CHECK(quality.ssim == 1.0 && quality.ssim_covered == 1.0 && quality.ms_ssim == 1.0);
    CHECK(quality.psnr == STP_PSNR_EQUAL);
    free(a.pixels);
    stp_context_destroy(context);
}

// For constant pictures the contrast term is 1, and only the luminance term remains.
void test_image_compare_of_constants_has_a_closed_form(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_image a = make_pattern(0), b = make_pattern(0);
    memset(a.pixels, 255, (size_t)PIXELS * 4);
    memset(b.pixels, 255, (size_t)PIXELS * 4);
    for (int i = 0; i < PIXELS; ++i) {
        memset(a.pixels + 4 * i, 200, 3);
        memset(b.pixels + 4 * i, 180, 3);
    }
    stp_image_quality quality;
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, NULL, &quality));
    double c1 = 2.55 * 2.55;
    double expected = (2.0 * 200.0 * 180.0 + c1) / (200.0 * 200.0 + 180.0 * 180.0 + c1);
    CHECK(is_near(expected, quality.ssim, 1e-9));
    CHECK(is_near(expected, quality.ssim_covered, 1e-9));
    CHECK(is_near(pow(expected, 0.1333), quality.ms_ssim, 1e-9));
    CHECK(is_near(20.0 * log10(255.0 / 20.0), quality.psnr, 1e-12));
    free(a.pixels);
    free(b.pixels);
    stp_context_destroy(context);
}

void test_image_compare_masks_and_coverage_choose_pixels(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_image a = make_pattern(0), b = make_pattern(0), mask = make_pattern(0);
    memset(a.pixels, 0, (size_t)PIXELS * 4);
    memset(b.pixels, 0, (size_t)PIXELS * 4);
    memset(mask.pixels, 0, (size_t)PIXELS * 4);
    stp_image_quality quality;
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, NULL, &quality));
    CHECK(quality.ssim_covered == 1.0); // nothing is covered
    // left half: a is white, b is covered and black; right half: both covered and grey
    for (int i = 0; i < PIXELS; ++i) {
        int is_left = i % WIDTH < WIDTH / 2;
        memset(a.pixels + 4 * i, is_left ? 255 : 90, 4);
        memset(b.pixels + 4 * i, is_left ? 0 : 90, 4);
        a.pixels[4 * i + 3] = 255;
        b.pixels[4 * i + 3] = (uint8_t)(is_left ? 0 : 255);
        // the mask: black on the left, transparent white on top, grey and white in the right half's
        // rest
        int is_top = i / WIDTH < 20;
        memset(mask.pixels + 4 * i, is_left ? 127 : 128, 4);
        mask.pixels[4 * i + 3] = (uint8_t)(is_top ? 0 : 255);
    }
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, NULL, &quality));
    CHECK(quality.ssim_covered < 0.55);
    double unmasked = quality.ssim_covered, whole = quality.ssim;
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, &mask, NULL, &quality));
    CHECK(quality.ssim_covered > 0.9 && quality.ssim_covered < 1.0 && unmasked < 0.55);
    CHECK(quality.ssim == whole); // the mask has no effect on it
    // an empty mask
    memset(mask.pixels, 0, (size_t)PIXELS * 4);
    CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, &mask, NULL, &quality));
    CHECK(quality.ssim_covered == 1.0);
    free(a.pixels);
    free(b.pixels);
    free(mask.pixels);
    stp_context_destroy(context);
}

void test_image_compare_is_the_same_for_any_threads(test_state* test)
{
    stp_image a = make_pattern(0), b = make_pattern(1), first_map = {0};
    stp_image_quality first = {0};
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        stp_image map;
        stp_image_quality quality = {0};
        CHECK_EQUAL(STP_OK, stp_image_compare(context, &a, &b, NULL, &map, &quality));
        if (threads == 1) {
            first = quality;
            first_map = crop(&map, 0, 0, WIDTH, HEIGHT);
        }
        CHECK(is_same(&first, &quality));
        CHECK(memcmp(first_map.pixels, map.pixels, (size_t)PIXELS * 4) == 0);
        stp_free(context, map.pixels);
        stp_context_destroy(context);
    }
    free(first_map.pixels);
    free(a.pixels);
    free(b.pixels);
}

void test_image_compare_refuses_other_sizes(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    stp_image a = make_pattern(0), b = crop(&a, 0, 0, WIDTH, HEIGHT - 1), none = {0};
    stp_image_quality quality;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_image_compare(context, &a, &b, NULL, NULL, &quality));
    CHECK(strcmp(log.text, "pictures of 203 x 171 and 203 x 170 cannot be compared") == 0);
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_image_compare(context, &a, &a, &b, NULL, &quality));
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_image_compare(context, &none, &none, NULL, NULL, &quality));
    CHECK_EQUAL(3, log.errors);
    free(a.pixels);
    free(b.pixels);
    stp_context_destroy(context);
}

void test_image_compare_survives_lack_of_memory(test_state* test)
{
    stp_image whole = make_pattern(0), a = crop(&whole, 0, 0, 40, 30),
              b = crop(&whole, 5, 5, 40, 30);
    for (int fail_at = 0;; ++fail_at) {
        test_heap heap = TEST_HEAP(fail_at);
        test_log log = {0};
        stp_context* context = test_context(&heap, 2, &log);
        if (context == NULL) {
            continue;
        }
        stp_image map;
        stp_image_quality quality;
        stp_result result = stp_image_compare(context, &a, &b, NULL, &map, &quality);
        if (result == STP_OK) {
            stp_free(context, map.pixels);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        if (result == STP_OK) {
            CHECK(heap.count <= fail_at);
            break;
        }
        CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
        CHECK_EQUAL(1, log.errors);
    }
    free(whole.pixels);
    free(a.pixels);
    free(b.pixels);
}
