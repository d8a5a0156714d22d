// SPDX-License-Identifier: MIT
#include "tests.h"

#include "import/reading/surface.h"

#include <string.h>

// Two by two pixels, from the top: red, green; blue with half alpha, white.
static const uint8_t wanted[16] = {255, 0, 0,   255, 0,   255, 0,   255,
                                   0,   0, 255, 128, 255, 255, 255, 255};

static const unsigned char tga_plain[] = {0,   0,   2, 0, 0,   0,   0,   0,   0, 0,   0,   0,
                                          2,   0,   2, 0, 32,  8,   255, 0,   0, 128, 255, 255,
                                          255, 255, 0, 0, 255, 255, 0,   255, 0, 255};
static const unsigned char tga_runs[] = {
    1,    0, 10, 0,   0,   0, 0, 0,   0, 0,   0,   0, 2, 0,   2,   0,   32,  0x28, 'x',
    0x80, 0, 0,  255, 255, 2, 0, 255, 0, 255, 255, 0, 0, 128, 255, 255, 255, 255};
static const unsigned char tga_mapped[] = {0,   1, 1, 0,   0,   4,   0,   32,  0,   0, 0,   0, 2,
                                           0,   2, 0, 8,   8,   0,   0,   255, 255, 0, 255, 0, 255,
                                           255, 0, 0, 128, 255, 255, 255, 255, 2,   3, 0,   1};
static const unsigned char bmp[] = {
    'B', 'M', 70, 0, 0,  0, 0,   0, 0, 0,   54,  0,   0, 0, 40, 0, 0,   0, 2,   0, 0, 0, 2, 0,
    0,   0,   1,  0, 24, 0, 0,   0, 0, 0,   0,   0,   0, 0, 0,  0, 0,   0, 0,   0, 0, 0, 0, 0,
    0,   0,   0,  0, 0,  0, 255, 0, 0, 255, 255, 255, 0, 0, 0,  0, 255, 0, 255, 0, 0, 0};

static const struct {
    const unsigned char* bytes;
    size_t size;
    int has_alpha;
} pictures[] = {{tga_plain, sizeof(tga_plain), 1},
                {tga_runs, sizeof(tga_runs), 1},
                {tga_mapped, sizeof(tga_mapped), 1},
                {bmp, sizeof(bmp), 0}};

void test_image_plain_pictures(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    for (size_t i = 0; i < sizeof(pictures) / sizeof(pictures[0]); ++i) {
        stp_texture texture = {0};
        const char* reason = NULL;
        CHECK_EQUAL(STP_OK, stp_image_decode_plain(context, pictures[i].bytes, pictures[i].size,
                                                   &texture, &reason));
        CHECK(texture.width == 2 && texture.height == 2);
        for (size_t k = 0; k < 16; ++k) {
            CHECK_EQUAL(k == 11 && !pictures[i].has_alpha ? 255 : wanted[k], texture.texels[k]);
        }
        stp_free(context, texture.texels);
    }
    stp_context_destroy(context);
}

static stp_result decode(stp_context* context, const unsigned char* bytes, size_t size,
                         uint8_t* texels)
{
    stp_texture texture = {0};
    const char* reason = NULL;
    stp_result result = stp_image_decode_plain(context, bytes, size, &texture, &reason);
    if (result == STP_OK) {
        memcpy(texels, texture.texels, 4 * (size_t)texture.width * texture.height);
        stp_free(context, texture.texels);
    }
    return result;
}

void test_image_plain_channels(test_state* test)
{
    // 5 bits a channel: red, green
    static const unsigned char tga16[] = {0, 0, 2, 0, 0, 0,  0,  0,    0,    0,    0,
                                          0, 2, 0, 1, 0, 16, 32, 0x00, 0x7C, 0xE0, 0x03};
    // no alpha bits: the fourth byte means nothing
    static const unsigned char tga32[] = {0, 0, 2, 0,  0,  0, 0, 0,   0, 0, 0,   0, 2,
                                          0, 1, 0, 32, 32, 0, 0, 255, 0, 0, 255, 0, 9};
    uint8_t texels[16] = {0};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, decode(context, tga16, sizeof(tga16), texels));
    CHECK(memcmp(texels, wanted, 8) == 0);
    CHECK_EQUAL(STP_OK, decode(context, tga32, sizeof(tga32), texels));
    CHECK(memcmp(texels, wanted, 8) == 0);
    unsigned char mirrored[sizeof(tga32)];
    memcpy(mirrored, tga32, sizeof(tga32));
    mirrored[17] |= 0x10; // from right to left
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, decode(context, mirrored, sizeof(mirrored), texels));
    stp_context_destroy(context);
}

// A BMP of two pixels with a palette of one entry, white: the other value has no colour.
void test_image_plain_short_palettes_end_in_black(test_state* test)
{
    unsigned char file[62] = {
        'B',      'M',        [10] = 58,  [14] = 40,  [18] = 2, [22] = 1, [26] = 1,
        [28] = 8, [54] = 255, [55] = 255, [56] = 255, [58] = 0, [59] = 7};
    uint8_t texels[16] = {0};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, decode(context, file, sizeof(file), texels));
    CHECK(memcmp(texels, (uint8_t[]){255, 255, 255, 255, 0, 0, 0, 255}, 8) == 0);
    file[10] = 53; // the pixels would begin in the header
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, decode(context, file, sizeof(file), texels));
    stp_context_destroy(context);
}

void test_image_plain_memory_is_limited(test_state* test)
{
    // a picture of 16,384 x 16,384 in a file of 100 bytes is refused before any allocation
    unsigned char large[100] = {[2] = 10, [13] = 64, [15] = 64, [16] = 24};
    uint8_t texels[16] = {0};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_ERROR_TRUNCATED, decode(context, large, sizeof(large), texels));
    stp_context_destroy(context);
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = 8192};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    static unsigned char square[18 + 3 * 64 * 64] = {[2] = 2, [12] = 64, [14] = 64, [16] = 24};
    stp_result result = decode(context, square, sizeof(square), texels);
    stp_context_destroy(context);
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, result);
}

// The last row is read in one piece, and a part of it is missing.
void test_image_plain_last_rows_are_whole(test_state* test)
{
    enum { WIDTH = 100, SIZE = 18 + 3 * WIDTH };
    static unsigned char row[SIZE] = {[2] = 2, [12] = WIDTH, [14] = 1, [16] = 24};
    uint8_t texels[4 * WIDTH];
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK_EQUAL(STP_OK, decode(context, row, SIZE, texels));
    for (size_t missing = 1; missing < 100; ++missing) {
        CHECK_EQUAL(STP_ERROR_TRUNCATED, decode(context, row, SIZE - missing, texels));
    }
    stp_context_destroy(context);
}

void test_image_plain_heights_have_ends(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    unsigned char copy[sizeof(bmp)];
    memcpy(copy, bmp, sizeof(bmp));
    memcpy(copy + 22, (const unsigned char[4]){0, 0, 0, 0x80},
           4); // the minimum, which has no negation
    stp_texture texture = {0};
    const char* reason = NULL;
    CHECK(stp_image_decode_plain(context, copy, sizeof(copy), &texture, &reason) != STP_OK);
    CHECK(reason != NULL);
    stp_context_destroy(context);
}

void test_image_plain_is_not_trusted(test_state* test)
{
    // every truncation is rejected; every changed byte is rejected or decodes within bounds
    stp_context* context = test_context(NULL, 1, NULL);
    for (size_t i = 0; i < sizeof(pictures) / sizeof(pictures[0]); ++i) {
        for (size_t k = 0; k < pictures[i].size; ++k) {
            unsigned char* copy = malloc(pictures[i].size);
            CHECK(copy != NULL);
            stp_texture texture = {0};
            const char* reason = NULL;
            memcpy(copy, pictures[i].bytes, pictures[i].size);
            unsigned char* cut = malloc(k + 1);
            CHECK(cut != NULL);
            memcpy(cut, copy, k);
            CHECK(stp_image_decode_plain(context, cut, k, &texture, &reason) != STP_OK &&
                  reason != NULL);
            free(cut);
            for (int value = 0; value < 256; value += 51) {
                copy[k] = (unsigned char)value;
                if (stp_image_decode_plain(context, copy, pictures[i].size, &texture, &reason) ==
                    STP_OK) {
                    stp_free(context, texture.texels);
                }
            }
            free(copy);
        }
    }
    stp_context_destroy(context);
}
