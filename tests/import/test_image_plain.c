// SPDX-License-Identifier: MIT
#include "tests.h"

#include "import/image_plain.h"

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
