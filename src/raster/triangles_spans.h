// SPDX-License-Identifier: MIT
// Draws triangles row by row and finds the first and last pixel of LANES rows at a time: almost
// nothing of a thin triangle's box is inside. Included by triangles_lanes.h.
//
// The column where an edge crosses a row is a quotient of integers. Small triangles estimate it in
// float and correct it by one; for others double is exact.
#pragma once

#include "raster/triangles_internal.h"

#include <assert.h>

/// Spans of at least this mean length are drawn row by row, shorter ones many rows at a time.
#define SPAN_LONG 5.0f

/// Nearness of small triangles from their edge functions opposite corners 1 and 2; `along` holds
/// the differences of nearness from corner 0 to these corners.
static inline lanes_float small_nearness(lanes_uint edge1, lanes_uint edge2,
                                         lanes_float inverse_area, lanes_float n0,
                                         const lanes_float along[2], lanes_float low,
                                         lanes_float high)
{
    lanes_float w1 = __builtin_convertvector((lanes_int)edge1, lanes_float);
    lanes_float w2 = __builtin_convertvector((lanes_int)edge2, lanes_float);
    lanes_float nearness = n0 + (w1 * inverse_area) * along[0];
    nearness = nearness + (w2 * inverse_area) * along[1];
    return lanes_min_float(lanes_max_float(nearness, low), high);
}

/// Pixels whose centres may be inside, inclusive.
typedef struct pixel_box {
    int32_t left, right, top, bottom;
} pixel_box;

/// A small triangle.
typedef struct span_walk {
    uint32_t at[3];   ///< edge functions with bias at the first pixel of the box
    int32_t fall[3];  ///< decrease per column
    uint32_t down[3]; ///< increase per row
    uint32_t bias[3];
    float inverse[3]; ///< 1 / abs(fall)
    float n0, along[2], inverse_area, low, high;
} span_walk;

/// Value of `inverse` for horizontal edges, which keep all columns of a row or none.
#define SPAN_NO_FALL 1e10f

/// LANES rows: their first and last columns, counted from the box's left, and edge functions 1 and
/// 2 (without bias) there.
typedef struct span_rows {
    lanes_int first, last;
    lanes_uint edge[3];
    lanes_int there; ///< rows with at least one pixel
} span_rows;

/// Narrows spans to the columns where an edge function, `value` at column 0, is at least 0.
static inline void narrow_spans(lanes_int value, int32_t fall, float inverse, int32_t width,
                                span_rows* rows)
{
    const lanes_float zero = {0};
    int32_t amount = fall < 0 ? -fall : fall;
    lanes_float ratio = (__builtin_convertvector(value, lanes_float) + 0.5f) * inverse;
    const lanes_float maximum = zero + (float)(width + 2), minimum = -maximum;
    ratio = lanes_min_float(lanes_max_float(ratio, minimum), maximum);
    lanes_int column = __builtin_convertvector(ratio + 256.0f, lanes_int) - 256; // rounded down
    // within 128 pixels the estimate is less than one column off
    lanes_int rest = value - column * amount;
    column += rest < 0;
    column -= rest >= amount;
    if (fall < 0) {
        rows->first = lanes_max(rows->first, -column);
    } else {
        rows->last = lanes_min(rows->last, column);
    }
}

/// Rows of the box from `row` on, counted from its top; `at` holds the edge functions in the first.
static inline span_rows find_spans(const pixel_box* box, const span_walk* walk,
                                   const uint32_t at[3], int32_t row)
{
    const lanes_int zero = {0};
    int32_t width = box->right - box->left;
    span_rows rows = {.first = zero, .last = zero + width};
    for (int k = 0; k < 3; ++k) {
        rows.edge[k] = (lanes_uint)lanes_index() * walk->down[k] + at[k];
        narrow_spans((lanes_int)rows.edge[k], walk->fall[k], walk->inverse[k], width, &rows);
    }
    rows.there = (rows.first <= rows.last) & (row + lanes_index() <= box->bottom - box->top);
    for (int k = 1; k < 3; ++k) {
        rows.edge[k] -= (lanes_uint)(rows.first * walk->fall[k]) + walk->bias[k];
    }
    return rows;
}

static inline lanes_int walk_nearness(const span_walk* walk, lanes_uint edge1, lanes_uint edge2)
{
    const lanes_float zero = {0};
    const lanes_float along[2] = {zero + walk->along[0], zero + walk->along[1]};
    return (lanes_int)small_nearness(edge1, edge2, zero + walk->inverse_area, zero + walk->n0,
                                     along, zero + walk->low, zero + walk->high);
}

/// Writes a pixel in each row of `bits`.
static inline void write_rows(uint64_t* pixels, size_t stride, uint32_t bits, lanes_int columns,
                              lanes_int nearness, uint32_t id)
{
    int32_t depth[LANES], column[LANES];
    memcpy(depth, &nearness, sizeof(depth));
    memcpy(column, &columns, sizeof(column));
    for (; bits != 0; bits &= bits - 1) {
        size_t lane = (size_t)__builtin_ctz(bits);
        uint64_t pixel = (uint64_t) ~(uint32_t)depth[lane] << 32 | id;
        uint64_t* place = pixels + lane * stride + column[lane];
        *place = pixel < *place ? pixel : *place;
    }
}

/// Short spans: a pixel of each row at once. @return fragments
static inline uint64_t fill_short(const stp_triangle_window* window, uint64_t* pixels,
                                  const span_walk* walk, span_rows rows, uint32_t id)
{
    uint64_t fragments = 0;
    for (uint32_t bits = lanes_sign_bits(rows.there); bits != 0;) {
        lanes_int nearness = walk_nearness(walk, rows.edge[1], rows.edge[2]);
        write_rows(pixels, window->stride, bits, rows.first, nearness, id);
        if (window->behind != 0) {
            write_rows(pixels + window->behind, window->stride, bits, rows.first, ~nearness, id);
        }
        fragments += (uint64_t)__builtin_popcount(bits);
        rows.first += 1;
        rows.edge[1] -= (uint32_t)walk->fall[1];
        rows.edge[2] -= (uint32_t)walk->fall[2];
        bits &= lanes_sign_bits(rows.first <= rows.last);
    }
    return fragments;
}

/// Long spans, LANES pixels at a time. @return fragments
static inline uint64_t fill_long(const stp_triangle_window* window, uint64_t* pixels,
                                 const span_walk* walk, const span_rows* rows, uint32_t id)
{
    int32_t first[LANES], last[LANES];
    uint32_t edge[2][LANES];
    memcpy(first, &rows->first, sizeof(first));
    memcpy(last, &rows->last, sizeof(last));
    memcpy(edge, &rows->edge[1], sizeof(edge));
    const lanes_uint index = (lanes_uint)lanes_index();
    const lanes_uint along1 = index * (uint32_t)walk->fall[1],
                     along2 = index * (uint32_t)walk->fall[2];
    uint64_t fragments = 0;
    for (uint32_t bits = lanes_sign_bits(rows->there); bits != 0; bits &= bits - 1) {
        size_t lane = (size_t)__builtin_ctz(bits);
        uint64_t* place = pixels + lane * window->stride + first[lane];
        lanes_uint e1 = edge[0][lane] - along1, e2 = edge[1][lane] - along2;
        int32_t left = last[lane] - first[lane] + 1;
        assert(first[lane] >= 0 && left > 0 && "rows that are there have pixels");
        fragments += (uint64_t)left;
        for (; left > 0; left -= LANES, place += LANES) {
            uint32_t some = left < LANES ? (1U << left) - 1 : LANES_ALL;
            lanes_int nearness = walk_nearness(walk, e1, e2);
            lanes_write(place, some, nearness, id);
            if (window->behind != 0) {
                lanes_write(place + window->behind, some, ~nearness, id);
            }
            e1 -= (uint32_t)walk->fall[1] * LANES;
            e2 -= (uint32_t)walk->fall[2] * LANES;
        }
    }
    return fragments;
}

/// Boxes at most a vector wide, and low, are tested pixel by pixel; narrow ones two rows at a time.
enum {
    NARROW_COLUMNS = LANES < 8 ? LANES : 8,
    NARROW_ROWS = LANES / NARROW_COLUMNS, ///< rows that lanes_write_narrow writes
    NARROW_HEIGHT = 6 * NARROW_ROWS,
    LOW_HEIGHT = 10,
};

/// Writes pixels of one or more rows.
static inline void write_box(uint64_t* pixels, size_t stride, uint32_t bits, lanes_int nearness,
                             uint32_t id, int rows)
{
    if (rows > 1) {
        lanes_write_narrow(pixels, stride, bits, nearness, id);
    } else {
        lanes_write(pixels, bits, nearness, id);
    }
}

/// @param columns,rows in a vector
/// @return fragments
static inline uint64_t fill_box(const stp_triangle_window* window, const pixel_box* box,
                                const span_walk* walk, uint32_t id, int columns, int rows)
{
    assert((columns & (columns - 1)) == 0 && columns * rows == LANES && "a vector of pixels");
    assert(box->right - box->left < columns && "one vector wide");
    const lanes_int column = lanes_index() & (columns - 1), row = lanes_index() / columns;
    const lanes_int in_width = column <= box->right - box->left;
    const int32_t height = box->bottom - box->top;
    lanes_uint e[3];
    for (int k = 0; k < 3; ++k) {
        e[k] = (lanes_uint)row * walk->down[k] - (lanes_uint)column * (uint32_t)walk->fall[k];
        e[k] += walk->at[k];
    }
    uint64_t fragments = 0;
    uint64_t* pixels = stp_triangle_row(window, box->top) + box->left;
    for (int32_t top = 0; top <= height; top += rows) {
        lanes_int inside = ~(lanes_int)(e[0] | e[1] | e[2]) & in_width & (row <= height - top);
        uint32_t bits = lanes_sign_bits(inside);
        if (bits != 0) {
            lanes_int nearness = walk_nearness(walk, e[1] - walk->bias[1], e[2] - walk->bias[2]);
            write_box(pixels, window->stride, bits, nearness, id, rows);
            if (window->behind != 0) {
                write_box(pixels + window->behind, window->stride, bits, ~nearness, id, rows);
            }
            fragments += (uint64_t)__builtin_popcount(bits);
        }
        for (int k = 0; k < 3; ++k) {
            e[k] += walk->down[k] * (uint32_t)rows;
        }
        pixels += (size_t)rows * window->stride;
    }
    return fragments;
}

static void draw_walk(const stp_triangle_window* window, pixel_box box, const span_walk* walk,
                      uint32_t id)
{
    assert(box.left >= 0 && box.left <= box.right && box.right < window->width &&
           box.top >= window->row_begin && box.top <= box.bottom && box.bottom < window->row_end);
    uint32_t at[3] = {walk->at[0], walk->at[1], walk->at[2]};
    int32_t height = box.bottom - box.top;
    if (box.right - box.left < NARROW_COLUMNS && height < NARROW_HEIGHT) {
        *window->fragments += fill_box(window, &box, walk, id, NARROW_COLUMNS, NARROW_ROWS);
        return;
    }
    if (box.right - box.left < LANES && height < LOW_HEIGHT) {
        *window->fragments += fill_box(window, &box, walk, id, LANES, 1);
        return;
    }
    const float pixel = 2.0f * (float)(STP_SUBPIXEL * STP_SUBPIXEL);
    bool is_long = walk->inverse_area * (pixel * SPAN_LONG * (float)(height + 1)) < 1.0f;
    uint64_t fragments = 0;
    for (int32_t row = 0; row <= height; row += LANES) {
        span_rows rows = find_spans(&box, walk, at, row);
        uint64_t* pixels = stp_triangle_row(window, box.top + row) + box.left;
        if (is_long) {
            fragments += fill_long(window, pixels, walk, &rows, id);
        } else {
            fragments += fill_short(window, pixels, walk, rows, id);
        }
        for (int k = 0; k < 3; ++k) {
            at[k] += walk->down[k] * LANES;
        }
    }
    *window->fragments += fragments;
}
