// SPDX-License-Identifier: MIT
#include "support_golden.h"

#include "program/present/picture_file.h"

#include <string.h>

enum { TOLERATED_LEVELS = 6, TOLERATED_PER_MILLION = 925 }; // 40 pixels of 208 x 208

/// Number of pixels that differ by more than TOLERATED_LEVELS; `difference` receives the levels.
static uint32_t count_different(const stp_image* a, const stp_image* b, stp_image* difference)
{
    uint32_t different = 0;
    for (size_t i = 0; i < (size_t)a->width * a->height; ++i) {
        int maximum = 0;
        for (size_t k = 0; k < 4; ++k) {
            int d = abs(a->pixels[4 * i + k] - b->pixels[4 * i + k]);
            maximum = d > maximum ? d : maximum;
        }
        memset(difference->pixels + 4 * i, maximum, 3);
        difference->pixels[4 * i + 3] = 255;
        different += maximum > TOLERATED_LEVELS;
    }
    return different;
}

static void write_pictures(stp_context* context, const char* name, stp_image* const pictures[3])
{
    static const char* const kinds[3] = {"expected", "got", "difference"};
    const char* folder = getenv("STP_TEST_OUTPUT");
    char path[512];
    for (int i = 0; i < 3; ++i) {
        snprintf(path, sizeof(path), "%s/stp_%s_%s.png", folder != NULL ? folder : "/tmp", name,
                 kinds[i]);
        if (stp_png_write(context, pictures[i], path) != STP_OK) {
            break;
        }
        fprintf(stderr, "%s\n", path);
    }
}

const char* golden_compare(stp_context* context, const char* name, stp_image* got)
{
    static uint8_t pixels[4 * GOLDEN_MAX];
    char path[512];
    snprintf(path, sizeof(path), STP_TEST_SOURCE_DIR "/tests/golden/draw/%s.png", name);
    const char* write = getenv("STP_WRITE_GOLDEN");
    if (write != NULL && strcmp(write, "1") == 0) {
        return stp_png_write(context, got, path) == STP_OK ? NULL : "cannot be written";
    }
    stp_image expected = {0}, difference = {got->width, got->height, pixels};
    const char* wrong = NULL;
    uint64_t size = (uint64_t)got->width * got->height;
    if (stp_png_read(context, path, &expected) != STP_OK) {
        wrong = "cannot be read";
    } else if (expected.width != got->width || expected.height != got->height ||
               size > GOLDEN_MAX) {
        wrong = "has another size";
    } else {
        uint64_t different = count_different(&expected, got, &difference);
        if (different * 1000000 > size * TOLERATED_PER_MILLION) {
            write_pictures(context, name, (stp_image* [3]){&expected, got, &difference});
            fprintf(stderr, "%llu pixels differ\n", (unsigned long long)different);
            wrong = "looks different";
        }
    }
    if (wrong != NULL) {
        fprintf(stderr, "golden picture %s %s\n", name, wrong);
    }
    stp_free(context, expected.pixels);
    return wrong;
}

const char* golden_draw(stp_context* context, stp_store* store, const char* name, stp_view view,
                        stp_quality quality, stp_draw_style style)
{
    static uint8_t pixels[4 * GOLDEN_MAX];
    stp_image image = {view.width, view.height, pixels};
    stp_renderer* renderer = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    if (view.width == 0 || (uint64_t)view.width * view.height > GOLDEN_MAX) {
        return "is too large";
    }
    stp_result result = stp_draw_cpu_create(context, store, &renderer);
    quality.early_switch = 1; // one splat replaces few triangles
    if (result == STP_OK) {
        result = stp_select(context, store, &view, &quality, &list);
    }
    if (result == STP_OK) {
        result = stp_renderer_draw(renderer, &view, &list, &style, &image, &stats);
    }
    stp_renderer_destroy(renderer);
    stp_draw_list_destroy(context, &list);
    return result == STP_OK ? golden_compare(context, name, &image) : "cannot be drawn";
}
