// SPDX-License-Identifier: MIT
#include "program/present/canvas.h"

#include "base/io/file.h"
#include "base/math/math.h"

#include <assert.h>
#include <math.h>
#include <stb_truetype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FONT_BYTES_MAX = 1 << 24, LETTER_SIDE_MAX = 256 };

struct canvas_font {
    stbtt_fontinfo info;
    unsigned char* bytes;
    bool loaded;
};

static const char* const font_paths[] = {
    "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf",
    "/usr/share/fonts/truetype/noto/NotoSans-Regular.ttf",
    "/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
};

static bool load_font(struct canvas_font* font, const char* path)
{
    font->bytes = malloc(FONT_BYTES_MAX);
    size_t size = font->bytes != NULL ? stp_file_peek(path, font->bytes, FONT_BYTES_MAX) : 0;
    font->loaded = size > 0 && size < FONT_BYTES_MAX && stbtt_InitFont(&font->info, font->bytes, 0);
    if (!font->loaded) {
        free(font->bytes);
        font->bytes = NULL;
    }
    return font->loaded;
}

stp_result canvas_create(stp_context* context, uint32_t width, uint32_t height, canvas* c)
{
    *c = (canvas){.context = context, .image = {.width = width, .height = height}};
    if (width > CANVAS_SIDE_MAX || height > CANVAS_SIDE_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "a sheet of %ux%u pixels exceeds the maximum of %d pixels per side", width,
                        height, CANVAS_SIDE_MAX);
    }
    size_t bytes = (size_t)width * height * 4;
    c->image.pixels = stp_alloc_array(context, bytes, 1);
    c->font = calloc(1, sizeof(*c->font));
    if (c->image.pixels == NULL || c->font == NULL) {
        canvas_destroy(c);
        return stp_fail_memory(context);
    }
    memset(c->image.pixels, 255, bytes);
    for (size_t i = 0; i < sizeof(font_paths) / sizeof(font_paths[0]); ++i) {
        if (load_font(c->font, font_paths[i])) {
            return STP_OK;
        }
    }
    stp_warn(context, "no font is installed (fonts-dejavu-core): the sheet has no text");
    return STP_OK;
}

void canvas_destroy(canvas* c)
{
    stp_free(c->context, c->image.pixels);
    if (c->font != NULL) {
        free(c->font->bytes);
    }
    free(c->font);
    *c = (canvas){.context = c->context};
}

// Mixes a colour into a pixel, `share` of 0 to 1.
static void mix(canvas* c, int x, int y, double share, canvas_color color)
{
    if (x < 0 || y < 0 || (uint32_t)x >= c->image.width || (uint32_t)y >= c->image.height) {
        return;
    }
    assert(share >= 0.0 && share <= 1.0 && "or the byte overflows");
    uint8_t* pixel = c->image.pixels + 4 * ((size_t)y * c->image.width + (size_t)x);
    for (int i = 0; i < 3; ++i) {
        pixel[i] = (uint8_t)(pixel[i] + share * (color.rgb[i] - pixel[i]) + 0.5);
    }
}

void canvas_fill(canvas* c, int x, int y, int width, int height, canvas_color color)
{
    for (int row = y; row < y + height; ++row) {
        for (int column = x; column < x + width; ++column) {
            mix(c, column, row, 1.0, color);
        }
    }
}

void canvas_line(canvas* c, const double from[2], const double to[2], double thickness,
                 canvas_color color)
{
    double along[2] = {to[0] - from[0], to[1] - from[1]};
    double square = along[0] * along[0] + along[1] * along[1], reach = 0.5 * thickness + 1.0;
    int low[2], high[2];
    for (int i = 0; i < 2; ++i) {
        low[i] = (int)floor(fmin(from[i], to[i]) - reach);
        high[i] = (int)ceil(fmax(from[i], to[i]) + reach);
    }
    for (int y = low[1]; y <= high[1]; ++y) {
        for (int x = low[0]; x <= high[0]; ++x) {
            double off[2] = {x - from[0], y - from[1]};
            double t = square > 0.0 ? (off[0] * along[0] + off[1] * along[1]) / square : 0.0;
            t = fmin(fmax(t, 0.0), 1.0);
            double distance = hypot(off[0] - t * along[0], off[1] - t * along[1]);
            double share = 0.5 * thickness + 0.5 - distance;
            if (share > 0.0) {
                mix(c, x, y, fmin(share, 1.0), color);
            }
        }
    }
}

void canvas_put(canvas* c, int x, int y, const stp_image* picture)
{
    for (uint32_t row = 0; row < picture->height; ++row) {
        for (uint32_t column = 0; column < picture->width; ++column) {
            const uint8_t* p = picture->pixels + 4 * ((size_t)row * picture->width + column);
            mix(c, x + (int)column, y + (int)row, p[3] / 255.0, (canvas_color){{p[0], p[1], p[2]}});
        }
    }
}

// The next code point of UTF-8; invalid UTF-8 gives a question mark.
static int next_point(const char** text)
{
    const unsigned char* at = (const unsigned char*)*text;
    int length = at[0] < 0x80 ? 1 : at[0] >= 0xF0 ? 4 : at[0] >= 0xE0 ? 3 : at[0] >= 0xC0 ? 2 : 0;
    int point = length <= 1 ? at[0] : at[0] & (0xFF >> (length + 1));
    for (int i = 1; i < length; ++i) {
        if ((at[i] & 0xC0) != 0x80) {
            length = 0;
            break;
        }
        point = point << 6 | (at[i] & 0x3F);
    }
    *text += length > 0 ? length : 1;
    return length > 0 ? point : '?';
}

static void put_letter(canvas* c, double x, int y, float scale, canvas_color color, int point)
{
    unsigned char mask[LETTER_SIDE_MAX * LETTER_SIDE_MAX];
    int box[4];
    float shift = (float)(x - floor(x));
    stbtt_GetCodepointBitmapBoxSubpixel(&c->font->info, point, scale, scale, shift, 0, &box[0],
                                        &box[1], &box[2], &box[3]);
    int width = box[2] - box[0], height = box[3] - box[1];
    if (width <= 0 || height <= 0 || width > LETTER_SIDE_MAX || height > LETTER_SIDE_MAX) {
        return;
    }
    stbtt_MakeCodepointBitmapSubpixel(&c->font->info, mask, width, height, width, scale, scale,
                                      shift, 0, point);
    for (int row = 0; row < height; ++row) {
        for (int column = 0; column < width; ++column) {
            mix(c, (int)floor(x) + box[0] + column, y + box[1] + row,
                mask[row * width + column] / 255.0, color);
        }
    }
}

// Measures only if `c` is NULL, else draws too. @return the width
static double walk_text(const struct canvas_font* font, canvas* c, int x, int y, double size,
                        canvas_color color, const char* text)
{
    float scale = stbtt_ScaleForPixelHeight(&font->info, (float)size);
    double at = 0.0;
    for (int before = 0; *text != '\0';) {
        int point = next_point(&text), advance, bearing;
        at += before != 0
                  ? (double)scale * stbtt_GetCodepointKernAdvance(&font->info, before, point)
                  : 0.0;
        if (c != NULL) {
            put_letter(c, x + at, y, scale, color, point);
        }
        stbtt_GetCodepointHMetrics(&font->info, point, &advance, &bearing);
        at += (double)scale * advance;
        before = point;
    }
    return at;
}

int canvas_text(canvas* c, int x, int y, double size, canvas_color color, const char* text)
{
    return c->font->loaded ? x + (int)ceil(walk_text(c->font, c, x, y, size, color, text)) : x;
}

int canvas_text_width(const canvas* c, double size, const char* text)
{
    return c->font->loaded
               ? (int)ceil(walk_text(c->font, NULL, 0, 0, size, (canvas_color){{0}}, text))
               : 0;
}

// Averages the source pixels of each pixel of the smaller picture by area; colours are weighted by
// alpha.
static void average(const stp_image* from, const double low[2], const double high[2],
                    uint8_t out[4])
{
    double sum[3] = {0.0}, alpha = 0.0, area = 0.0;
    for (uint32_t y = (uint32_t)low[1]; y < from->height && y < high[1]; ++y) {
        double tall = fmin(high[1], y + 1.0) - fmax(low[1], y);
        for (uint32_t x = (uint32_t)low[0]; x < from->width && x < high[0]; ++x) {
            double part = tall * (fmin(high[0], x + 1.0) - fmax(low[0], x));
            const uint8_t* p = from->pixels + 4 * ((size_t)y * from->width + x);
            for (int i = 0; i < 3; ++i) {
                sum[i] += part * p[i] * p[3];
            }
            alpha += part * p[3];
            area += part;
        }
    }
    for (int i = 0; i < 3; ++i) {
        out[i] = (uint8_t)(alpha > 0.0 ? sum[i] / alpha + 0.5 : 0.0);
    }
    out[3] = (uint8_t)(area > 0.0 ? alpha / area + 0.5 : 0.0);
}

stp_result canvas_fit(stp_context* context, const stp_image* picture, uint32_t width,
                      uint32_t height, stp_image* fitted)
{
    assert(picture->width > 0 && picture->height > 0 && "the ratio is finite");
    double ratio = fmin((double)width / picture->width, (double)height / picture->height);
    ratio = ratio >= 1.0 ? floor(ratio) : ratio;
    *fitted = (stp_image){.width = (uint32_t)fmax(1.0, floor(picture->width * ratio + 0.5)),
                          .height = (uint32_t)fmax(1.0, floor(picture->height * ratio + 0.5))};
    fitted->pixels = stp_alloc_array(context, (size_t)fitted->width * fitted->height, 4);
    if (fitted->pixels == NULL) {
        return stp_fail_memory(context);
    }
    double step[2] = {(double)picture->width / fitted->width,
                      (double)picture->height / fitted->height};
    for (uint32_t y = 0; y < fitted->height; ++y) {
        for (uint32_t x = 0; x < fitted->width; ++x) {
            const double low[2] = {x * step[0], y * step[1]};
            const double high[2] = {low[0] + step[0], low[1] + step[1]};
            average(picture, low, high, fitted->pixels + 4 * ((size_t)y * fitted->width + x));
        }
    }
    return STP_OK;
}
