// SPDX-License-Identifier: MIT
#include "draw/enlarge.h"

#include "base/core/context.h"
#include "select/eyes.h"

#include <assert.h>
#include <string.h>

enum { ROWS_AT_ONCE = 16 };

typedef stp_enlarged_channels channels;
typedef uint8_t channel_bytes __attribute__((vector_size(4)));

static uint32_t scale_side(uint32_t side, double share)
{
    double scaled = (double)side * share + 0.5;
    return scaled < 1.0 ? 1 : (uint32_t)scaled;
}

stp_view stp_enlarge_view(const stp_view* view, double share)
{
    assert(share > 0.0 && share < 1.0);
    stp_view small = *view;
    uint32_t eyes = stp_view_eye_count(view);
    small.height = scale_side(view->height, share);
    // the height's share, which is rounded, is that of the picture
    share = (double)small.height / (double)view->height;
    small.width = eyes * scale_side(view->width / eyes, share);
    return small;
}

stp_result stp_enlarge_begin(stp_context* context, const stp_view* small, stp_enlargement* e,
                             stp_image* image)
{
    size_t bytes = 4 * (size_t)small->width * small->height;
    if (!STP_MAKE_ROOM(context, e->pixels, e->pixel_capacity, bytes)) {
        return stp_fail_memory(context);
    }
    *image = (stp_image){small->width, small->height, e->pixels};
    return STP_OK;
}

/// Place of a pixel's centre among `count` pixels, where there are `of`: 256ths of a pixel from the
/// first one's centre, within the picture.
static uint32_t find_place(uint32_t at, uint32_t of, uint32_t count)
{
    uint64_t place = (2 * (uint64_t)at + 1) * count * 128 / of;
    uint64_t last = 256 * (uint64_t)(count - 1);
    place = place > 128 ? place - 128 : 0;
    return (uint32_t)(place < last ? place : last);
}

typedef struct enlarging {
    const stp_image *small, *image;
    const stp_enlargement* e;
    uint32_t eyes;
} enlarging;

/// Columns that are enlarged together, and at most as many pixels between which they lie, with one
/// more for reading pairs.
enum { TILE = 64, TILE_SOURCE = TILE + 2 };

/// Source pixels of a tile, mixed from two rows; colours times alpha unless all are opaque.
typedef struct source_row {
    uint16_t of[4 * (TILE_SOURCE + 2)];
    bool opaque;
} source_row;

/// Colours times alpha. Most pixels are open or opaque.
static void weigh_row(const uint8_t* pixels, uint32_t count, uint8_t* out)
{
    memcpy(out, pixels, 4 * (size_t)count);
    for (uint32_t i = 0; i < count; ++i, out += 4) {
        uint32_t alpha = out[3];
        if (alpha == 0) {
            memset(out, 0, 4);
        }
        for (int c = 0; c < 3 && alpha > 0 && alpha < 255; ++c) {
            out[c] = (uint8_t)((out[c] * alpha + 127) / 255);
        }
    }
}

static void mix_rows(const uint8_t* restrict above, const uint8_t* restrict below, uint32_t count,
                     uint32_t share, uint16_t* restrict out)
{
    const uint16_t down = (uint16_t)share, up = (uint16_t)(256 - share);
    for (uint32_t i = 0; i < 4 * count; ++i) {
        out[i] = (uint16_t)((uint16_t)(above[i] * up + below[i] * down + 128) >> 8);
    }
}

static void make_source(const uint8_t* above, const uint8_t* below, uint32_t count, uint32_t share,
                        source_row* row)
{
    assert(count <= TILE_SOURCE);
    uint32_t alpha = 255;
    for (uint32_t i = 0; i < count; ++i) {
        alpha &= (uint32_t)above[4 * i + 3] & below[4 * i + 3];
    }
    row->opaque = alpha == 255;
    if (row->opaque) {
        mix_rows(above, below, count, share, row->of);
        return;
    }
    uint8_t weighed[2][4 * TILE_SOURCE];
    weigh_row(above, count, weighed[0]);
    weigh_row(below, count, weighed[1]);
    mix_rows(weighed[0], weighed[1], count, share, row->of);
}

static channels unweigh(channels pixel)
{
    uint32_t alpha = pixel[3];
    for (int c = 0; c < 3 && alpha > 0 && alpha < 255; ++c) {
        uint32_t color = (pixel[c] * 255u + alpha / 2) / alpha;
        pixel[c] = (uint16_t)(color < 255 ? color : 255);
    }
    return pixel;
}

/// Up to TILE columns of a row. @param down  share of the lower row
static void enlarge_tile(const uint8_t* above, const uint8_t* below, uint32_t down,
                         const stp_enlarged_column* columns, uint32_t count, uint8_t* out)
{
    uint32_t first = columns[0].left, width = columns[count - 1].right - first + 1;
    source_row row;
    make_source(above + 4 * (size_t)first, below + 4 * (size_t)first, width, down, &row);
    memset(row.of + 4 * (size_t)width, 0, 8); // read with a share of 0
    for (uint32_t x = 0; x < count; ++x, out += 4) {
        const uint16_t* left = row.of + 4 * (size_t)(columns[x].left - first);
        channels a, b;
        memcpy(&a, left, sizeof(a));
        memcpy(&b, left + 4, sizeof(b));
        channels mixed = (a * columns[x].shares[0] + b * columns[x].shares[1] + (uint16_t)128) >> 8;
        mixed = row.opaque ? mixed : unweigh(mixed);
        channel_bytes bytes = __builtin_convertvector(mixed, channel_bytes);
        memcpy(out, &bytes, sizeof(bytes));
    }
}

static void enlarge_rows(size_t begin, size_t end, uint32_t worker, void* user)
{
    const enlarging* job = user;
    const stp_image *small = job->small, *image = job->image;
    uint32_t width = image->width / job->eyes, small_width = small->width / job->eyes;
    (void)worker;
    for (size_t y = begin; y < end; ++y) {
        uint32_t place = find_place((uint32_t)y, image->height, small->height);
        size_t row = place >> 8, next = row + ((place & 255) != 0 ? 1 : 0);
        uint8_t* out = image->pixels + 4 * y * image->width;
        memset(out + 4 * ((size_t)image->width - 1), 0, 4); // odd widths: belongs to no eye
        for (uint32_t eye = 0; eye < job->eyes; ++eye) {
            size_t first = (size_t)eye * small_width;
            const uint8_t* above = small->pixels + 4 * (row * small->width + first);
            const uint8_t* below = small->pixels + 4 * (next * small->width + first);
            for (uint32_t x = 0; x < width; x += TILE) {
                uint32_t count = width - x < TILE ? width - x : TILE;
                enlarge_tile(above, below, place & 255, job->e->columns + x, count,
                             out + 4 * (eye * (size_t)width + x));
            }
        }
    }
}

stp_result stp_enlarge_picture(stp_context* context, stp_enlargement* e, const stp_image* small,
                               uint32_t eyes, stp_image* image)
{
    uint32_t width = image->width / eyes, small_width = small->width / eyes;
    assert(small->width <= image->width && small->height <= image->height && small_width > 0);
    if (!STP_MAKE_ROOM(context, e->columns, e->column_capacity, width)) {
        return stp_fail_memory(context);
    }
    for (uint32_t x = 0; x < width; ++x) {
        uint32_t place = find_place(x, width, small_width), share = place & 255;
        e->columns[x].left = place >> 8;
        e->columns[x].right = (place >> 8) + (share != 0 ? 1 : 0);
        for (int c = 0; c < 4; ++c) {
            e->columns[x].shares[0][c] = (uint16_t)(256 - share);
            e->columns[x].shares[1][c] = (uint16_t)share;
        }
    }
    enlarging job = {.small = small, .image = image, .e = e, .eyes = eyes};
    stp_parallel_for(context, image->height, ROWS_AT_ONCE, enlarge_rows, &job);
    return STP_OK;
}

const float* stp_enlarge_nearness(stp_context* context, stp_enlargement* e, const stp_view* small,
                                  const float* nearness, const stp_view* view)
{
    uint32_t eyes = stp_view_eye_count(view);
    size_t width = view->width / eyes, small_width = small->width / eyes;
    size_t count = (size_t)eyes * width * view->height;
    if (!STP_MAKE_ROOM(context, e->nearness, e->nearness_capacity, count)) {
        return NULL;
    }
    float* out = e->nearness;
    for (uint32_t eye = 0; eye < eyes; ++eye, nearness += small_width * small->height) {
        for (uint32_t y = 0; y < view->height; ++y) {
            const float* row =
                nearness + small_width * ((find_place(y, view->height, small->height) + 128) >> 8);
            for (uint32_t x = 0; x < width; ++x) {
                *out++ = row[(find_place(x, (uint32_t)width, (uint32_t)small_width) + 128) >> 8];
            }
        }
    }
    return e->nearness;
}

void stp_enlargement_destroy(stp_context* context, stp_enlargement* e)
{
    stp_free(context, e->pixels);
    stp_free(context, e->nearness);
    stp_free(context, e->columns);
    *e = (stp_enlargement){0};
}
