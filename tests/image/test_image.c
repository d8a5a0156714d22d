// SPDX-License-Identifier: MIT
#include "tests.h"

#include "image/image_codecs.h"

#include <spng.h>
#include <string.h>
#include <turbojpeg.h>
#include <webp/encode.h>

// Encodes rows of the given kind; the caller frees (libspng's malloc).
static void* encode_png(uint32_t width, uint32_t height, uint8_t color_type, uint8_t depth,
                        const void* rows, size_t row_bytes, size_t* size)
{
    spng_ctx* png = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    struct spng_ihdr header = {
        .width = width, .height = height, .bit_depth = depth, .color_type = color_type};
    spng_set_ihdr(png, &header);
    if (color_type == SPNG_COLOR_TYPE_INDEXED) {
        struct spng_plte palette = {.n_entries = 2,
                                    .entries = {{.red = 10, .green = 20, .blue = 30},
                                                {.red = 200, .green = 100, .blue = 50}}};
        struct spng_trns alpha = {.n_type3_entries = 2, .type3_alpha = {255, 64}};
        spng_set_plte(png, &palette);
        spng_set_trns(png, &alpha);
    }
    void* bytes = NULL;
    if (spng_encode_image(png, rows, row_bytes * height, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE) == 0) {
        int error = 0;
        bytes = spng_get_png_buffer(png, size, &error);
    }
    spng_ctx_free(png);
    return bytes;
}

void test_image_decodes_every_png_kind(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    const uint8_t grey[4] = {0, 255, 7, 90};
    const uint8_t grey_alpha[8] = {0, 1, 255, 2, 7, 3, 90, 4};
    const uint8_t rgb[12] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12};
    const uint8_t indexed[4] = {0, 1, 1, 0};
    const uint16_t rgba16[16] = {0xAB12, 0xFFFF, 0, 0x80FF, [12] = 0x0102, 0x0304, 0x0506, 0x0708};
    const struct {
        uint8_t color_type, depth;
        const void* rows;
        size_t row_bytes;
        uint8_t first[4], last[4];
    } cases[] = {
        {SPNG_COLOR_TYPE_GRAYSCALE, 8, grey, 2, {0, 0, 0, 255}, {90, 90, 90, 255}},
        {SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 8, grey_alpha, 4, {0, 0, 0, 1}, {90, 90, 90, 4}},
        {SPNG_COLOR_TYPE_TRUECOLOR, 8, rgb, 6, {1, 2, 3, 255}, {10, 11, 12, 255}},
        {SPNG_COLOR_TYPE_INDEXED, 8, indexed, 2, {10, 20, 30, 255}, {10, 20, 30, 255}},
        {SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 16, rgba16, 16, {0xAB, 0xFF, 0, 0x80}, {1, 3, 5, 7}},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        size_t size = 0;
        unsigned char* bytes = encode_png(2, 2, cases[i].color_type, cases[i].depth, cases[i].rows,
                                          cases[i].row_bytes, &size);
        CHECK(bytes != NULL);
        stp_image texture = {0};
        CHECK_EQUAL(STP_OK, stp_image_decode(context, "a.png", bytes, size, &texture));
        CHECK_EQUAL(2, texture.width);
        CHECK_EQUAL(2, texture.height);
        CHECK(memcmp(texture.pixels, cases[i].first, 4) == 0);
        CHECK(memcmp(texture.pixels + 12, cases[i].last, 4) == 0);
        stp_free(context, texture.pixels);
        free(bytes);
    }
    stp_context_destroy(context);
}

void test_image_decodes_jpeg_and_webp(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    uint8_t rows[16 * 16 * 4];
    for (size_t i = 0; i < sizeof(rows); i += 4) {
        memcpy(rows + i, (const uint8_t[4]){200, 100, 50, 255}, 4);
    }
    const int formats[] = {TJPF_RGBA, TJPF_GRAY, TJPF_CMYK};
    const int sampling[] = {TJSAMP_420, TJSAMP_GRAY, TJSAMP_444};
    for (int i = 0; i < 3; ++i) {
        tjhandle jpeg = tjInitCompress();
        unsigned char* bytes = NULL;
        unsigned long size = 0;
        CHECK(tjCompress2(jpeg, rows, 16, 0, 16, formats[i], &bytes, &size, sampling[i], 95, 0) ==
              0);
        stp_image texture = {0};
        CHECK_EQUAL(STP_OK, stp_image_decode(context, "a.jpg", bytes, size, &texture));
        CHECK_EQUAL(16, texture.width);
        CHECK_EQUAL(255, texture.pixels[3]);
        CHECK(i != 0 || (abs(texture.pixels[0] - 200) <= 3 && abs(texture.pixels[2] - 50) <= 3));
        CHECK(i != 2 || abs(texture.pixels[0] - 200) <= 3);
        stp_free(context, texture.pixels);
        tjFree(bytes);
        tjDestroy(jpeg);
    }
    uint8_t* webp = NULL;
    size_t webp_size = WebPEncodeLosslessRGBA(rows, 16, 16, 64, &webp);
    CHECK(webp_size > 0);
    stp_image texture = {0};
    CHECK_EQUAL(STP_OK, stp_image_decode(context, "a.webp", webp, webp_size, &texture));
    CHECK(memcmp(texture.pixels, rows, sizeof(rows)) == 0);
    stp_free(context, texture.pixels);
    WebPFree(webp);
    stp_context_destroy(context);
}

void test_image_refuses_every_truncation(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    uint8_t rows[12 * 12 * 4];
    for (size_t i = 0; i < sizeof(rows); ++i) {
        rows[i] = (uint8_t)(i * 37 + i / 7);
    }
    unsigned char* bytes[3] = {NULL};
    size_t sizes[3] = {0};
    bytes[0] = encode_png(12, 12, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8, rows, 48, &sizes[0]);
    tjhandle jpeg = tjInitCompress();
    unsigned long jpeg_size = 0;
    CHECK(tjCompress2(jpeg, rows, 12, 0, 12, TJPF_RGBA, &bytes[1], &jpeg_size, TJSAMP_444, 90, 0) ==
          0);
    sizes[1] = jpeg_size;
    sizes[2] = WebPEncodeLosslessRGBA(rows, 12, 12, 48, &bytes[2]);
    for (int kind = 0; kind < 3; ++kind) {
        // the last bytes of each are not needed for pixels: checksums, an end marker, padding
        size_t needed = sizes[kind] - (kind == 0 ? 20 : kind == 1 ? 4 : 2);
        for (size_t size = 0; size < needed; ++size) {
            unsigned char* cut = malloc(size + 1); // sanitizers detect reads past its end
            CHECK(cut != NULL);
            memcpy(cut, bytes[kind], size);
            stp_image texture = {0};
            int errors = log.errors;
            stp_result result = stp_image_decode(context, "a", cut, size, &texture);
            CHECK(result == STP_ERROR_FORMAT || result == STP_ERROR_UNSUPPORTED);
            CHECK_EQUAL(errors + 1, log.errors);
            free(cut);
        }
    }
    free(bytes[0]);
    tjFree(bytes[1]);
    WebPFree(bytes[2]);
    tjDestroy(jpeg);
    stp_context_destroy(context);
}

void test_image_refuses_absurd_sizes(test_state* test)
{
    test_log log = {.errors = 0};
    stp_context* context = test_context(NULL, 1, &log);
    size_t size = 0;
    const uint8_t pixel[1] = {0};
    unsigned char* bytes = encode_png(1, 1, SPNG_COLOR_TYPE_GRAYSCALE, 8, pixel, 1, &size);
    CHECK(bytes != NULL && size > 33);
    memcpy(bytes + 16, "\x00\x00\x40\x00\x00\x00\x40\x00", 8); // 16384 x 16384, and its checksum
    memcpy(bytes + 29, "\x8c\xa3\x4f\x58", 4);
    stp_image texture = {0};
    stp_result result = stp_image_decode(context, "a.png", bytes, size, &texture);
    CHECK(result == STP_ERROR_LIMIT || result == STP_ERROR_FORMAT);
    CHECK(texture.pixels == NULL);
    free(bytes);
    stp_context_destroy(context);
}

void test_image_believes_in_proportion_to_bytes(test_state* test)
{
    const uint64_t always = UINT64_C(1) << 26;
    CHECK(stp_image_is_plausible(0, 0) && stp_image_is_plausible(always, 1));
    CHECK(!stp_image_is_plausible(always + 260, 1) && !stp_image_is_plausible(UINT64_MAX, 1 << 30));
    CHECK(stp_image_is_plausible(4 * always,
                                 4 * always / 258));   // one RGBA colour, compressed by deflate
    CHECK(!stp_image_is_plausible(4 * always, 65546)); // the same with a palette of two
}

void test_image_survives_failing_allocator(test_state* test)
{
    uint8_t rows[4 * 4 * 4] = {1, 2, 3, 4};
    size_t size = 0;
    unsigned char* bytes = encode_png(4, 4, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 8, rows, 16, &size);
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_image texture = {0};
        stp_result result = STP_ERROR_OUT_OF_MEMORY;
        if (context != NULL) {
            result = stp_image_decode(context, "a.png", bytes, size, &texture);
            stp_free(context, texture.pixels);
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            break;
        }
    }
    free(bytes);
}
