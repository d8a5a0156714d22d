// SPDX-License-Identifier: MIT
// Triangles at least 128 pixels wide or high, row by row. Included by triangles_lanes.h.
#pragma once

#include "raster/triangles_spans.h"

#include <assert.h>

/// Sub-pixels: for smaller triangles, edge functions and the columns computed from them are exact
/// in double.
enum { DOUBLE_EXTENT = 1 << 19 };

/// An edge function: its value with bias at the box's first pixel, its decrease per column and its
/// increase per row.
typedef struct large_edge {
    double at, fall, down, inverse; ///< inverse: 1 / abs(fall)
} large_edge;

/// A triangle that is not small.
typedef struct large_walk {
    const stp_triangle_setup* setup;
    stp_triangle_edge edges[3];
    large_edge doubles[3];
    stp_triangle_plane plane;
    bool fits_double;
} large_walk;

enum { LARGE_ROWS = LANES / 2 };

/// Rows whose columns are computed together.
typedef struct large_rows {
    lanes_real first, last; ///< columns of the picture; empty if first > last
} large_rows;

static inline lanes_real min_real(lanes_real a, lanes_real b)
{
    lanes_long mask = a < b;
    return (lanes_real)((mask & (lanes_long)a) | (~mask & (lanes_long)b));
}

/// 0, 1, 2 and so on.
static inline lanes_real count_rows(void)
{
    lanes_real rows = {0};
    for (int i = 0; i < LARGE_ROWS; ++i) {
        rows[i] = (double)i;
    }
    return rows;
}

static inline large_edge make_large_edge(const stp_triangle_edge* edge,
                                         const stp_triangle_setup* setup)
{
    large_edge made = {
        .at = (double)(stp_triangle_edge_at(edge, setup->left, setup->top) + edge->bias),
        .fall = (double)(edge->dy * STP_SUBPIXEL),
        .down = (double)(edge->dx * STP_SUBPIXEL),
    };
    double amount = made.fall < 0.0 ? -made.fall : made.fall;
    made.inverse = amount > 0.0 ? 1.0 / amount : 1e10;
    return made;
}

static inline large_walk make_large_walk(const stp_triangle_setup* setup)
{
    large_walk walk = {.setup = setup, .plane = stp_triangle_plane_make(setup)};
    int32_t reach = 0;
    for (int k = 0; k < 3; ++k) {
        const stp_screen_vertex *a = &setup->corner[k], *b = &setup->corner[(k + 1) % 3];
        walk.edges[k] = stp_triangle_edge_make(*a, *b);
        walk.doubles[k] = make_large_edge(&walk.edges[k], setup);
        int32_t x = a->x < b->x ? b->x - a->x : a->x - b->x;
        int32_t y = a->y < b->y ? b->y - a->y : a->y - b->y;
        reach = stp_triangle_max(reach, stp_triangle_max(x, y));
    }
    walk.fits_double = reach < DOUBLE_EXTENT;
    return walk;
}

/// Columns of rows from `row` on. Quotients are off by less than 2^-40 and differ from integers by
/// at least 2^-28.
static inline void find_columns(const large_walk* walk, int32_t row, large_rows* rows)
{
    const stp_triangle_setup* setup = walk->setup;
    const double round = 6755399441055744.0; // adding and subtracting it rounds to an integer
    const lanes_real lines = count_rows() + (double)(row - setup->top);
    lanes_real first = {0}, last = first + (double)(setup->right - setup->left);
    const lanes_real maximum = last + 2.0;
    for (int k = 0; k < 3; ++k) {
        const large_edge* edge = &walk->doubles[k];
        lanes_real ratio = ((lines * edge->down + edge->at) + 0.5) * edge->inverse;
        ratio = min_real(ratio, maximum);
        ratio = -min_real(-ratio, maximum);
        lanes_real column = ((ratio - 0.5) + round) - round;
        if (edge->fall < 0.0) {
            first = -min_real(-first, column);
        } else {
            last = min_real(last, column);
        }
    }
    rows->first = first + (double)setup->left;
    rows->last = last + (double)setup->left;
}

/// Same for triangles whose edge functions are not exact in double.
static void find_columns_one_by_one(const large_walk* walk, int32_t row, large_rows* rows)
{
    for (int i = 0; i < LARGE_ROWS; ++i) {
        int64_t first = walk->setup->left, last = walk->setup->right;
        for (int k = 0; k < 3 && row + i <= walk->setup->bottom; ++k) {
            stp_triangle_edge_narrow(&walk->edges[k], row + i, &first, &last);
        }
        rows->first[i] = (double)first;
        rows->last[i] = (double)last;
    }
}

/// Short spans: a pixel of each row of `bits` at once. @return fragments
static inline uint64_t fill_large_short(const stp_triangle_window* window, const large_walk* walk,
                                        int32_t top, const large_rows* rows, uint32_t bits,
                                        uint32_t id)
{
    const stp_triangle_plane* plane = &walk->plane;
    const float low = walk->setup->low, high = walk->setup->high;
    const lanes_real y =
        (count_rows() + (double)top) * (double)STP_SUBPIXEL + (double)STP_SUBPIXEL_HALF;
    const lanes_real row_nearness = plane->nearness + plane->along_y * (y - plane->y);
    uint64_t* pixels = stp_triangle_row(window, top);
    lanes_real column = rows->first;
    uint64_t fragments = 0;
    while (bits != 0) { // as stp_triangle_plane_at
        lanes_real x = column * (double)STP_SUBPIXEL + (double)STP_SUBPIXEL_HALF;
        lanes_real at = row_nearness + plane->along_x * (x - plane->x);
        double ats[LARGE_ROWS], columns[LARGE_ROWS];
        memcpy(ats, &at, sizeof(ats));
        memcpy(columns, &column, sizeof(columns));
        for (uint32_t left = bits; left != 0; left &= left - 1) {
            size_t lane = (size_t)__builtin_ctz(left);
            float nearness = (float)ats[lane];
            nearness = nearness > low ? nearness : low;
            nearness = nearness < high ? nearness : high;
            uint64_t pixel = stp_raster_pixel(nearness, id);
            uint64_t* place = pixels + lane * window->stride + (int32_t)columns[lane];
            *place = pixel < *place ? pixel : *place;
            if (window->behind != 0) {
                stp_triangle_write_behind(place + window->behind, pixel);
            }
        }
        fragments += (uint64_t)__builtin_popcount(bits);
        column += 1.0;
        bits &= lanes_long_bits(column <= rows->last);
    }
    return fragments;
}

/// Long spans, LANES pixels of a row at a time. @return fragments
static inline uint64_t fill_large_long(const stp_triangle_window* window, const large_walk* walk,
                                       int32_t top, const large_rows* rows, uint32_t bits,
                                       uint32_t id)
{
    const lanes_float zero = {0};
    const lanes_real low_steps = count_rows() * (double)STP_SUBPIXEL + (double)STP_SUBPIXEL_HALF;
    const lanes_real high_steps = low_steps + (double)(LANES / 2 * STP_SUBPIXEL);
    const float low = walk->setup->low, high = walk->setup->high;
    const lanes_float lowest = zero + low, highest = zero + high;
    const double along_x = walk->plane.along_x, plane_x = walk->plane.x;
    double firsts[LARGE_ROWS], lasts[LARGE_ROWS];
    memcpy(firsts, &rows->first, sizeof(firsts));
    memcpy(lasts, &rows->last, sizeof(lasts));
    uint64_t fragments = 0;
    for (; bits != 0; bits &= bits - 1) {
        int lane = __builtin_ctz(bits);
        uint64_t* row = stp_triangle_row(window, top + lane);
        double row_nearness = stp_triangle_plane_row(&walk->plane, top + lane);
        int32_t first = (int32_t)firsts[lane], last = (int32_t)lasts[lane];
        assert(first >= walk->setup->left && last <= walk->setup->right && first <= last);
        double start = (double)first * (double)STP_SUBPIXEL; // integers, so sums are exact
        lanes_real low_x = low_steps + start, high_x = high_steps + start;
        for (int32_t column = first; column <= last; column += LANES) { // as stp_triangle_plane_at
            lanes_float nearness = lanes_narrow(row_nearness + along_x * (low_x - plane_x),
                                                row_nearness + along_x * (high_x - plane_x));
            nearness = lanes_min_float(lanes_max_float(nearness, lowest), highest);
            int32_t left = last - column + 1;
            uint32_t some = left < LANES ? (1U << left) - 1 : LANES_ALL;
            lanes_write(row + column, some, (lanes_int)nearness, id);
            if (window->behind != 0) {
                lanes_write(row + window->behind + column, some, ~(lanes_int)nearness, id);
            }
            low_x += (double)(LANES * STP_SUBPIXEL);
            high_x += (double)(LANES * STP_SUBPIXEL);
        }
        fragments += (uint64_t)(last - first) + 1;
    }
    return fragments;
}

static void draw_large(const stp_triangle_window* window, const stp_triangle_setup* setup,
                       uint32_t id)
{
    assert(!setup->small && setup->left >= 0 && setup->right < window->width &&
           setup->top >= window->row_begin && setup->bottom < window->row_end);
    const large_walk walk = make_large_walk(setup);
    const double pixels_twice = (double)setup->area / (double)(STP_SUBPIXEL * STP_SUBPIXEL);
    const double rows_twice = 2.0 * (double)(setup->bottom - setup->top + 1);
    const bool is_long = pixels_twice > rows_twice * (double)SPAN_LONG;
    uint64_t fragments = 0;
    for (int32_t top = setup->top; top <= setup->bottom; top += LARGE_ROWS) {
        large_rows rows = {0};
        if (walk.fits_double) {
            find_columns(&walk, top, &rows);
        } else {
            find_columns_one_by_one(&walk, top, &rows);
        }
        uint32_t bits = lanes_long_bits(rows.first <= rows.last);
        int32_t left = setup->bottom - top + 1;
        bits &= left < LARGE_ROWS ? (1U << left) - 1 : UINT32_MAX;
        if (is_long) {
            fragments += fill_large_long(window, &walk, top, &rows, bits, id);
        } else {
            fragments += fill_large_short(window, &walk, top, &rows, bits, id);
        }
    }
    *window->fragments += fragments;
}
