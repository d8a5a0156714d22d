// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/io/file.h"
#include "image/image_codecs.h"
#include "program/present/picture_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum { WIDTH = 61, HEIGHT = 43, JPEG_ERROR = 12 };

// Smooth colours; the left half is covered, the right half background.
static void fill(unsigned char* pixels)
{
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        int x = i % WIDTH, y = i / WIDTH;
        unsigned char* p = pixels + 4 * (size_t)i;
        p[0] = (unsigned char)(40 + 2 * x);
        p[1] = (unsigned char)(60 + 3 * y);
        p[2] = (unsigned char)(200 - x - y);
        p[3] = x < 32 ? 255 : 0;
    }
}

static bool read_back(stp_context* context, const char* path, stp_image_kind kind, stp_image* out)
{
    stp_mapped_file file;
    stp_image_info info = {0};
    bool good = stp_file_map(context, path, &file) == STP_OK &&
                stp_image_measure(file.bytes, file.size, &info) == STP_OK && info.kind == kind &&
                stp_image_decode(context, path, file.bytes, file.size, out) == STP_OK;
    stp_file_unmap(&file);
    return good && out->width == WIDTH && out->height == HEIGHT;
}

void test_picture_file_format_follows_its_name(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    uint64_t live_bytes = stp_context_live_bytes(context);
    static unsigned char pixels[WIDTH * HEIGHT * 4];
    stp_image image = {WIDTH, HEIGHT, pixels};
    fill(pixels);
    char folder[] = "stipple-test-XXXXXX", path[64];
    CHECK(mkdtemp(folder) != NULL);

    snprintf(path, sizeof(path), "%s/a.webp", folder);
    stp_image webp = {0};
    CHECK_EQUAL(STP_OK, stp_picture_write(context, &image, path));
    CHECK(read_back(context, path, STP_IMAGE_WEBP, &webp));
    for (size_t i = 0; i < sizeof(pixels); i += 4) { // transparent pixels may lose their colour
        CHECK(webp.pixels[i + 3] == pixels[i + 3]);
        CHECK(pixels[i + 3] == 0 || memcmp(webp.pixels + i, pixels + i, 4) == 0);
    }
    stp_free(context, webp.pixels);
    (void)unlink(path);

    snprintf(path, sizeof(path), "%s/a.JPG", folder);
    stp_image jpeg = {0};
    CHECK_EQUAL(STP_OK, stp_picture_write(context, &image, path));
    CHECK(read_back(context, path, STP_IMAGE_JPEG, &jpeg));
    for (int i = 0; i < WIDTH * HEIGHT; ++i) {
        int x = i % WIDTH;
        for (int c = 0; c < 3 && (x < 24 || x >= 40);
             ++c) { // away from the edge between the halves
            int wanted = x < 32 ? pixels[4 * i + c] : 255;
            CHECK(abs(jpeg.pixels[4 * i + c] - wanted) <= JPEG_ERROR);
        }
    }
    stp_free(context, jpeg.pixels);
    (void)unlink(path);
    (void)rmdir(folder);
    CHECK_EQUAL(live_bytes, stp_context_live_bytes(context));
    stp_context_destroy(context);
}

void test_picture_file_refuses_unsupported_formats(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    unsigned char pixel[4] = {1, 2, 3, 255};
    stp_image image = {1, 1, pixel};
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, stp_picture_write(context, &image, "a.bmp"));
    CHECK(strstr(log.text, "a.bmp: the file name must end in .png, .jpg, .jpeg or .webp") != NULL);
    CHECK_EQUAL(STP_PICTURE_PNG, stp_picture_format_of("folder.bmp/a"));
    CHECK_EQUAL(STP_PICTURE_JPEG, stp_picture_format_of("folder.bmp/a.JPeG"));
    image.width = 20000; // refused before a pixel is read
    CHECK_EQUAL(STP_ERROR_LIMIT, stp_picture_write(context, &image, "a.webp"));
    stp_context_destroy(context);
}
