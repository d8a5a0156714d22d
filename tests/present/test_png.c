// SPDX-License-Identifier: MIT
#include "tests.h"

#include "program/present/picture_file.h"

#include <spng.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

// Every byte value in every channel, smooth and rough parts, all alphas.
static void fill(stp_image* image, unsigned char* pixels, uint32_t width, uint32_t height)
{
    *image = (stp_image){.width = width, .height = height, .pixels = pixels};
    for (uint32_t i = 0; i < width * height; ++i) {
        uint32_t x = i % width, y = i / width;
        pixels[4 * i + 0] = (unsigned char)(x * 7 + y);
        pixels[4 * i + 1] = (unsigned char)((x * x * 31) ^ (y * 57));
        pixels[4 * i + 2] = (unsigned char)(y * 3);
        pixels[4 * i + 3] = (unsigned char)(x % 3 == 0 ? 255 : y);
    }
}

void test_png_keeps_every_pixel(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    uint64_t live_bytes = stp_context_live_bytes(context);
    static unsigned char pixels[61 * 43 * 4];
    static const uint32_t sizes[][2] = {{1, 1}, {1, 43}, {61, 1}, {2, 3}, {61, 43}};
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); ++i) {
        stp_image image, back;
        fill(&image, pixels, sizes[i][0], sizes[i][1]);
        unsigned char* bytes;
        size_t size;
        CHECK_EQUAL(STP_OK, stp_png_encode(context, &image, "test", &bytes, &size));
        CHECK_EQUAL(STP_OK, stp_png_decode(context, "test", bytes, size, &back));
        CHECK_EQUAL(image.width, back.width);
        CHECK_EQUAL(image.height, back.height);
        CHECK(memcmp(pixels, back.pixels, (size_t)image.width * image.height * 4) == 0);
        stp_free(context, back.pixels);
        stp_free(context, bytes);
    }
    CHECK_EQUAL(live_bytes, stp_context_live_bytes(context));
    stp_context_destroy(context);
}

void test_png_file_is_written_and_read(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    char folder[] = "stipple-test-XXXXXX", path[64];
    CHECK(mkdtemp(folder) != NULL);
    snprintf(path, sizeof(path), "%s/picture.png", folder);
    static unsigned char pixels[61 * 43 * 4];
    stp_image image, back;
    fill(&image, pixels, 61, 43);
    CHECK_EQUAL(STP_OK, stp_png_write(context, &image, path));
    CHECK_EQUAL(STP_OK, stp_png_read(context, path, &back));
    CHECK(memcmp(pixels, back.pixels, sizeof(pixels)) == 0);
    stp_free(context, back.pixels);
    CHECK_EQUAL(0, unlink(path));
    CHECK_EQUAL(STP_ERROR_IO, stp_png_read(context, path, &back));
    CHECK(strstr(log.text, "picture.png") != NULL);
    // no other file is left in the folder
    CHECK_EQUAL(0, rmdir(folder));
    CHECK_EQUAL(STP_ERROR_IO, stp_png_write(context, &image, path));
    CHECK_EQUAL(2, log.errors);
    stp_context_destroy(context);
}

// Encodes `pixels` (in the format of the header) with libspng alone.
static unsigned char* encode_other(struct spng_ihdr header, struct spng_plte* palette,
                                   struct spng_trns* transparency, const void* pixels, size_t size,
                                   size_t* encoded_size)
{
    spng_ctx* codec = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(codec, SPNG_ENCODE_TO_BUFFER, 1);
    int code = spng_set_ihdr(codec, &header);
    code = palette != NULL && code == 0 ? spng_set_plte(codec, palette) : code;
    code = transparency != NULL && code == 0 ? spng_set_trns(codec, transparency) : code;
    code = code == 0 ? spng_encode_image(codec, pixels, size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE)
                     : code;
    unsigned char* bytes = code == 0 ? spng_get_png_buffer(codec, encoded_size, &code) : NULL;
    spng_ctx_free(codec);
    return bytes;
}

void test_png_other_kinds_become_rgba(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static const uint16_t grey16[] = {0x0000, 0x8000, 0xffff, 0x1234};
    static const unsigned char rgb[] = {1, 2, 3, 250, 251, 252}, indices[] = {0x1b}; // 0 1 2 3
    struct spng_plte palette = {
        .n_entries = 4,
        .entries = {{10, 20, 30, 0}, {40, 50, 60, 0}, {70, 80, 90, 0}, {9, 8, 7, 0}}};
    struct spng_trns transparency = {.n_type3_entries = 2, .type3_alpha = {0, 128}};
    const struct {
        struct spng_ihdr header;
        const void* pixels;
        size_t size;
        unsigned char expected[16];
    } cases[] = {
        {{4, 1, 16, SPNG_COLOR_TYPE_GRAYSCALE, 0, 0, 0},
         grey16,
         sizeof(grey16),
         {0, 0, 0, 255, 128, 128, 128, 255, 255, 255, 255, 255, 0x12, 0x12, 0x12, 255}},
        {{2, 1, 8, SPNG_COLOR_TYPE_TRUECOLOR, 0, 0, 0},
         rgb,
         sizeof(rgb),
         {1, 2, 3, 255, 250, 251, 252, 255}},
        {{4, 1, 2, SPNG_COLOR_TYPE_INDEXED, 0, 0, 0},
         indices,
         sizeof(indices),
         {10, 20, 30, 0, 40, 50, 60, 128, 70, 80, 90, 255, 9, 8, 7, 255}},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        int is_indexed = cases[i].header.color_type == SPNG_COLOR_TYPE_INDEXED;
        size_t size;
        unsigned char* bytes =
            encode_other(cases[i].header, is_indexed ? &palette : NULL,
                         is_indexed ? &transparency : NULL, cases[i].pixels, cases[i].size, &size);
        CHECK(bytes != NULL);
        stp_image image;
        CHECK_EQUAL(STP_OK, stp_png_decode(context, "test", bytes, size, &image));
        CHECK_EQUAL(cases[i].header.width, image.width);
        CHECK(memcmp(cases[i].expected, image.pixels, (size_t)image.width * 4) == 0);
        stp_free(context, image.pixels);
        free(bytes);
    }
    stp_context_destroy(context);
}

void test_png_truncated_or_broken_is_refused(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    uint64_t live_bytes = stp_context_live_bytes(context);
    unsigned char pixels[5 * 4 * 4];
    stp_image image, back;
    fill(&image, pixels, 5, 4);
    unsigned char* bytes;
    size_t size;
    CHECK_EQUAL(STP_OK, stp_png_encode(context, &image, "test", &bytes, &size));
    // each prefix in a buffer of its own, so that sanitizers detect reads past its end; the
    // checksum of the last chunk, which is empty, is not verified
    for (size_t length = 0; length + 4 < size; ++length) {
        unsigned char* prefix = malloc(length + 1);
        CHECK(prefix != NULL);
        memcpy(prefix, bytes, length);
        CHECK_EQUAL(STP_ERROR_FORMAT, stp_png_decode(context, "cut.png", prefix, length, &back));
        CHECK_EQUAL(length + 1, log.errors);
        CHECK(strncmp(log.text, "cut.png: PNG: ", 14) == 0);
        free(prefix);
    }
    // every byte is covered by a checksum, a signature or a length
    for (size_t i = 0; i + 4 < size; ++i) {
        bytes[i] ^= 0x10;
        stp_result result = stp_png_decode(context, "broken.png", bytes, size, &back);
        CHECK(result == STP_ERROR_FORMAT || result == STP_ERROR_LIMIT);
        bytes[i] ^= 0x10;
    }
    stp_free(context, bytes);
    CHECK_EQUAL(live_bytes, stp_context_live_bytes(context));
    stp_context_destroy(context);
}

void test_png_size_beyond_its_bytes_is_refused(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    // a signature and a header with a correct checksum: 16384 x 16384 and 65536 x 65536 pixels
    static const unsigned char huge[2][33] = {
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x40\0\0\0\x40\0\x08\x06\0\0\0\xa9\xc8\x10\x84",
        "\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\1\0\0\0\1\0\0\x08\x06\0\0\0\x6c\x84\x30\xe3",
    };
    stp_image image;
    CHECK_EQUAL(STP_ERROR_FORMAT,
                stp_png_decode(context, "huge.png", huge[0], sizeof(huge[0]), &image));
    CHECK(strcmp(log.text, "huge.png: PNG: 16384 x 16384 pixels do not fit into 33 bytes") == 0);
    CHECK_EQUAL(STP_ERROR_LIMIT,
                stp_png_decode(context, "huge.png", huge[1], sizeof(huge[1]), &image));
    CHECK_EQUAL(2, log.errors);
    CHECK(stp_context_peak_bytes(context) < 1 << 20);
    stp_context_destroy(context);
}

void test_png_survives_lack_of_memory(test_state* test)
{
    unsigned char pixels[5 * 4 * 4];
    stp_image image, back;
    fill(&image, pixels, 5, 4);
    for (int fail_at = 0;; ++fail_at) {
        test_heap heap = TEST_HEAP(fail_at);
        test_log log = {0};
        stp_context* context = test_context(&heap, 1, &log);
        if (context == NULL) {
            continue;
        }
        unsigned char* bytes = NULL;
        size_t size = 0;
        stp_result result = stp_png_encode(context, &image, "test", &bytes, &size);
        if (result == STP_OK) {
            result = stp_png_decode(context, "test", bytes, size, &back);
            if (result == STP_OK) {
                stp_free(context, back.pixels);
            }
            stp_free(context, bytes);
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
}
