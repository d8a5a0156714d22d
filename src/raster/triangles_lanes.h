// SPDX-License-Identifier: MIT
// The triangle kernels, for vectors of LANES numbers. Included once by each variant, which defines
// the types lanes_int, lanes_uint, lanes_float and the few operations that need its own
// instructions.
//
// Most triangles of a capture are smaller than a pixel and hit no pixel centre; the test of their
// bounding box rejects them, LANES at a time. Tiny ones are drawn LANES triangles at a time, pixel
// by pixel; larger ones one at a time (triangles_spans.h, triangles_large.h).
#pragma once

#include "raster/triangles_internal.h"
#include "raster/triangles_large.h"

#include <assert.h>

enum { TINY_WIDTH = 4, TINY_HEIGHT = 8 };

static void transform_vertices(const stp_triangle_transform* transform, const float* positions,
                               size_t count, int32_t* x, int32_t* y, float* nearness)
{
    const float(*m)[4] = transform->matrix;
    const float* offset = transform->offset;
    const float guard = (float)STP_GUARD_BAND;
    for (size_t i = 0; i < count; i += LANES) {
        float padded[3 * LANES] = {0};
        const float* source = positions + 3 * i;
        if (count - i < LANES) {
            memcpy(padded, source, (count - i) * 3 * sizeof(float));
            source = padded;
        }
        lanes_int words[3];
        lanes_load3(source, words);
        lanes_float px = (lanes_float)words[0] - offset[0];
        lanes_float py = (lanes_float)words[1] - offset[1];
        lanes_float pz = (lanes_float)words[2] - offset[2];
        lanes_float sx = px * m[0][0] + py * m[0][1] + pz * m[0][2] + m[0][3];
        lanes_float sy = px * m[1][0] + py * m[1][1] + pz * m[1][2] + m[1][3];
        lanes_float sn = px * m[2][0] + py * m[2][1] + pz * m[2][2] + m[2][3];
        lanes_float sw = px * m[3][0] + py * m[3][1] + pz * m[3][2] + m[3][3];
        lanes_float inverse = 1.0f / sw;
        lanes_float gx = (sx * inverse) * (float)STP_SUBPIXEL;
        lanes_float gy = (sy * inverse) * (float)STP_SUBPIXEL;
        lanes_float gn = sn * inverse;
        lanes_int inside = (gx >= -guard) & (gx <= guard) & (gy >= -guard) & (gy <= guard) &
                           (gn >= STP_MIN_NEARNESS) & (gn <= transform->nearness_limit) &
                           (sw >= STP_MIN_W);
        lanes_int grid_x = lanes_round(gx), grid_y = lanes_round(gy);
        memcpy(x + i, &grid_x, sizeof(grid_x));
        memcpy(y + i, &grid_y, sizeof(grid_y));
        memcpy(nearness + i, &gn, sizeof(gn));
        for (uint32_t out = ~lanes_sign_bits(inside) & LANES_ALL; out != 0; out &= out - 1) {
            size_t lane = (size_t)__builtin_ctz(out);
            x[i + lane] = STP_OUTSIDE;
            y[i + lane] = (int32_t)stp_triangle_outcode(sx[lane], sy[lane], sn[lane], sw[lane],
                                                        transform->nearness_limit);
        }
    }
}

static void find_range(const uint32_t* indices, size_t count, uint32_t* minimum, uint32_t* maximum)
{
    uint32_t low = UINT32_MAX, high = 0;
    for (size_t i = 0; i < count; ++i) {
        low = indices[i] < low ? indices[i] : low;
        high = indices[i] > high ? indices[i] : high;
    }
    *minimum = low;
    *maximum = high;
}

/// Draws a single small triangle.
static void draw_small(const stp_triangle_window* window, const stp_triangle_setup* setup,
                       uint32_t id)
{
    assert(setup->small && setup->area <= INT32_MAX && "edge functions fit 32 bits");
    pixel_box box = {setup->left, setup->right, setup->top, setup->bottom};
    float n0 = setup->corner[0].nearness;
    span_walk walk = {
        .n0 = n0,
        .along = {setup->corner[1].nearness - n0, setup->corner[2].nearness - n0},
        .inverse_area = 1.0f / (float)setup->area,
        .low = setup->low,
        .high = setup->high,
    };
    for (int k = 0; k < 3; ++k) {
        stp_triangle_edge edge =
            stp_triangle_edge_make(setup->corner[(k + 1) % 3], setup->corner[(k + 2) % 3]);
        int64_t first = stp_triangle_edge_at(&edge, setup->left, setup->top) + edge.bias;
        int32_t fall = (int32_t)edge.dy * STP_SUBPIXEL;
        walk.at[k] = (uint32_t)first;
        walk.fall[k] = fall;
        walk.down[k] = (uint32_t)edge.dx * STP_SUBPIXEL;
        walk.bias[k] = (uint32_t)edge.bias;
        walk.inverse[k] = fall != 0 ? 1.0f / (float)(fall < 0 ? -fall : fall) : SPAN_NO_FALL;
    }
    draw_walk(window, box, &walk, id);
}

static void draw_one(const stp_triangle_window* window, const stp_screen_vertex corners[3],
                     uint32_t id)
{
    stp_triangle_setup setup;
    if (!stp_triangle_set_up(window, corners, &setup)) {
        return;
    }
    if (setup.small) {
        draw_small(window, &setup, id);
    } else {
        draw_large(window, &setup, id);
    }
}

/// LANES triangles: corners in sub-pixels, and the pixels in their boxes.
typedef struct batch {
    lanes_int x[3], y[3];
    lanes_int left, top;     ///< first pixel of the box
    lanes_int width, height; ///< pixels of the box, minus one
    lanes_float nearness[3];
} batch;

/// LANES small triangles after setup, oriented so that their areas are positive.
typedef struct batch_setup {
    lanes_uint at[3]; ///< edge functions with bias at the first pixel of the box
    lanes_uint dx[3], dy[3], bias[3];
    lanes_float n0, along[2], inverse_area, low, high;
} batch_setup;

/// Sets up all lanes. @return the lanes whose triangles have a non-zero area and face the right way
static inline lanes_int set_up_batch(const batch* b, int32_t facing, batch_setup* setup)
{
    lanes_uint x0 = (lanes_uint)b->x[0], y0 = (lanes_uint)b->y[0];
    lanes_uint x1 = (lanes_uint)b->x[1] - x0, y1 = (lanes_uint)b->y[1] - y0;
    lanes_uint x2 = (lanes_uint)b->x[2] - x0, y2 = (lanes_uint)b->y[2] - y0;
    lanes_int area = (lanes_int)(x1 * y2 - y1 * x2);
    lanes_int has_area = area != 0, turned = area < 0;
    has_area = facing > 0 ? has_area & ~turned : facing < 0 ? has_area & turned : has_area;
    area = lanes_select(turned, -area, area);
    lanes_uint ux1 = (lanes_uint)lanes_select(turned, (lanes_int)x2, (lanes_int)x1);
    lanes_uint uy1 = (lanes_uint)lanes_select(turned, (lanes_int)y2, (lanes_int)y1);
    lanes_uint ux2 = (lanes_uint)lanes_select(turned, (lanes_int)x1, (lanes_int)x2);
    lanes_uint uy2 = (lanes_uint)lanes_select(turned, (lanes_int)y1, (lanes_int)y2);
    // edges 1 -> 2, 2 -> 0, 0 -> 1: opposite corners 0, 1, 2
    const lanes_uint dx[3] = {ux2 - ux1, -ux2, ux1}, dy[3] = {uy2 - uy1, -uy2, uy1};
    lanes_uint cx = ((lanes_uint)b->left << STP_SUBPIXEL_BITS) + (uint32_t)STP_SUBPIXEL_HALF - x0;
    lanes_uint cy = ((lanes_uint)b->top << STP_SUBPIXEL_BITS) + (uint32_t)STP_SUBPIXEL_HALF - y0;
    const lanes_uint from_x[3] = {cx - ux1, cx - ux2, cx}, from_y[3] = {cy - uy1, cy - uy2, cy};
    for (int k = 0; k < 3; ++k) {
        lanes_int not_left = ~((lanes_int)dy[k] < 0);
        lanes_int not_top = ((lanes_int)dy[k] != 0) | ((lanes_int)dx[k] <= 0);
        setup->bias[k] = (lanes_uint)(not_left & not_top); // 0 or -1
        setup->dx[k] = dx[k];
        setup->dy[k] = dy[k];
        setup->at[k] = dx[k] * from_y[k] - dy[k] * from_x[k] + setup->bias[k];
    }
    lanes_float n0 = b->nearness[0];
    lanes_float n1 = lanes_select_float(turned, b->nearness[2], b->nearness[1]);
    lanes_float n2 = lanes_select_float(turned, b->nearness[1], b->nearness[2]);
    lanes_float low = lanes_select_float(n1 < n2, n1, n2);
    lanes_float high = lanes_select_float(n1 > n2, n1, n2);
    setup->n0 = n0;
    setup->along[0] = n1 - n0;
    setup->along[1] = n2 - n0;
    setup->inverse_area = 1.0f / __builtin_convertvector(area, lanes_float);
    setup->low = lanes_select_float(n0 < low, n0, low);
    setup->high = lanes_select_float(n0 > high, n0, high);
    return has_area;
}

/// Ids of consecutive triangles. The compiler makes draw_chunk twice, with and without numbers.
typedef struct triangle_ids {
    uint32_t first;
    const uint32_t* numbers; ///< NULL: 0, 1, 2, ...
} triangle_ids;

static inline uint32_t find_id(triangle_ids ids, uint32_t triangle)
{
    return ids.first + (ids.numbers != NULL ? ids.numbers[triangle] : triangle);
}

static inline triangle_ids skip_ids(triangle_ids ids, uint32_t count)
{
    return ids.numbers != NULL ? (triangle_ids){ids.first, ids.numbers + count}
                               : (triangle_ids){ids.first + count, NULL};
}

/// Writes one pixel of each triangle in `bits`: the same place in each one's box.
static inline void write_lanes(const stp_triangle_window* window, const batch* b, int32_t row,
                               int32_t column, uint32_t bits, lanes_float nearness,
                               triangle_ids ids)
{
    float depth[LANES];
    memcpy(depth, &nearness, sizeof(depth));
    *window->fragments += (uint64_t)__builtin_popcount(bits);
    for (; bits != 0; bits &= bits - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(bits);
        uint64_t* place = stp_triangle_row(window, b->top[lane] + row) + b->left[lane] + column;
        uint64_t pixel = stp_raster_pixel(depth[lane], find_id(ids, lane));
        *place = pixel < *place ? pixel : *place;
        if (window->behind != 0) {
            stp_triangle_write_behind(place + window->behind, pixel);
        }
    }
}

/// Draws the triangles of `alive` (sign bits), at most TINY_WIDTH wide and TINY_HEIGHT high: all
/// triangles at once, pixel by pixel of their boxes.
static inline void draw_tiny(const stp_triangle_window* window, const batch* b, batch_setup* setup,
                             lanes_int alive, triangle_ids ids)
{
    for (int32_t row = 0; row < TINY_HEIGHT; ++row) {
        lanes_int in_row = alive & (b->height >= row);
        if (lanes_sign_bits(in_row) == 0) {
            break;
        }
        lanes_uint e[3] = {setup->at[0], setup->at[1], setup->at[2]};
        for (int32_t column = 0; column < TINY_WIDTH; ++column) {
            lanes_int here = in_row & (b->width >= column);
            if (lanes_sign_bits(here) == 0) {
                break;
            }
            uint32_t bits = lanes_sign_bits(here & ~(lanes_int)(e[0] | e[1] | e[2]));
            if (bits != 0) {
                lanes_float nearness = small_nearness(e[1] - setup->bias[1], e[2] - setup->bias[2],
                                                      setup->inverse_area, setup->n0, setup->along,
                                                      setup->low, setup->high);
                write_lanes(window, b, row, column, bits, nearness, ids);
            }
            for (int k = 0; k < 3; ++k) {
                e[k] -= setup->dy[k] << STP_SUBPIXEL_BITS;
            }
        }
        for (int k = 0; k < 3; ++k) {
            setup->at[k] += setup->dx[k] << STP_SUBPIXEL_BITS;
        }
    }
}

/// Draws the triangles of `lanes`, one after the other.
static inline void draw_medium(const stp_triangle_window* window, const batch* b,
                               const batch_setup* setup, uint32_t lanes, triangle_ids ids)
{
    const lanes_float none = (lanes_float){0} + SPAN_NO_FALL;
    lanes_int fall[3];
    lanes_float inverse[3];
    for (int k = 0; k < 3 && lanes != 0; ++k) {
        fall[k] = (lanes_int)setup->dy[k] * STP_SUBPIXEL;
        lanes_int amount = lanes_max(fall[k], -fall[k]);
        inverse[k] = 1.0f / __builtin_convertvector(amount, lanes_float);
        inverse[k] = lanes_select_float(amount == 0, none, inverse[k]);
    }
    for (; lanes != 0; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        pixel_box box = {b->left[lane], b->left[lane] + b->width[lane], b->top[lane],
                         b->top[lane] + b->height[lane]};
        span_walk walk = {
            .n0 = setup->n0[lane],
            .along = {setup->along[0][lane], setup->along[1][lane]},
            .inverse_area = setup->inverse_area[lane],
            .low = setup->low[lane],
            .high = setup->high[lane],
        };
        for (int k = 0; k < 3; ++k) {
            walk.at[k] = setup->at[k][lane];
            walk.fall[k] = fall[k][lane];
            walk.down[k] = setup->dx[k][lane] * STP_SUBPIXEL;
            walk.bias[k] = setup->bias[k][lane];
            walk.inverse[k] = inverse[k][lane];
        }
        draw_walk(window, box, &walk, find_id(ids, (uint32_t)lane));
    }
}

static inline void draw_batch(const stp_triangle_window* window, const batch* b, lanes_int small,
                              uint32_t valid, triangle_ids ids)
{
    batch_setup setup;
    small &= set_up_batch(b, window->facing, &setup); // lanes past the end have no area
    lanes_int tiny = small & (b->width < TINY_WIDTH) & (b->height < TINY_HEIGHT);
    draw_medium(window, b, &setup, lanes_sign_bits(small & ~tiny) & valid, ids);
    if (lanes_sign_bits(tiny) != 0) {
        draw_tiny(window, b, &setup, tiny, ids);
    }
}

static void draw_lane(stp_triangle_chunk* chunk, uint32_t triangle)
{
    stp_screen_vertex corners[3];
    int outside = 0, shared_code = -1;
    for (int k = 0; k < 3; ++k) {
        uint32_t v = chunk->indices[3 * (size_t)triangle + (size_t)k] - chunk->index_base;
        corners[k] = (stp_screen_vertex){chunk->x[v], chunk->y[v], chunk->nearness[v]};
        bool out = chunk->x[v] == STP_OUTSIDE;
        outside |= out;
        shared_code &= out ? chunk->y[v] : 0;
    }
    if (!outside) {
        draw_one(&chunk->window, corners,
                 find_id((triangle_ids){chunk->first_id, chunk->numbers}, triangle));
    } else if (shared_code == 0) { // else all corners lie beyond one plane
        assert(chunk->clipped_count < chunk->triangle_count);
        chunk->clipped[chunk->clipped_count++] = triangle;
    }
}

static inline void draw_chunk_as(stp_triangle_chunk* chunk, triangle_ids ids)
{
    const stp_triangle_window* window = &chunk->window;
    const int32_t* nearness_words = (const int32_t*)(const void*)chunk->nearness;
    for (uint32_t t = 0; t < chunk->triangle_count; t += LANES) {
        uint32_t left_over = chunk->triangle_count - t;
        const uint32_t* indices = chunk->indices + 3 * (size_t)t;
        uint32_t valid = LANES_ALL, padded[3 * LANES];
        if (left_over < LANES) {
            for (int i = 0; i < 3 * LANES; ++i) {
                padded[i] = chunk->index_base;
            }
            memcpy(padded, indices, (size_t)left_over * 3 * sizeof(uint32_t));
            indices = padded;
            valid = (1U << left_over) - 1;
        }
        lanes_int index[3];
        lanes_load3(indices, index);
        batch b;
        for (int k = 0; k < 3; ++k) {
            index[k] = (lanes_int)((lanes_uint)index[k] - chunk->index_base);
            b.x[k] = lanes_gather(chunk->x, index[k]);
            b.y[k] = lanes_gather(chunk->y, index[k]);
        }
        lanes_int min_x = lanes_min(b.x[0], lanes_min(b.x[1], b.x[2]));
        lanes_int max_x = lanes_max(b.x[0], lanes_max(b.x[1], b.x[2]));
        lanes_int min_y = lanes_min(b.y[0], lanes_min(b.y[1], b.y[2]));
        lanes_int max_y = lanes_max(b.y[0], lanes_max(b.y[1], b.y[2]));
        lanes_int zero = {0};
        b.left = lanes_max((min_x + (STP_SUBPIXEL_HALF - 1)) >> STP_SUBPIXEL_BITS, zero);
        b.top = lanes_max((min_y + (STP_SUBPIXEL_HALF - 1)) >> STP_SUBPIXEL_BITS,
                          zero + window->row_begin);
        b.width = lanes_min((max_x - STP_SUBPIXEL_HALF) >> STP_SUBPIXEL_BITS,
                            zero + (window->width - 1)) -
                  b.left;
        b.height = lanes_min((max_y - STP_SUBPIXEL_HALF) >> STP_SUBPIXEL_BITS,
                             zero + (window->row_end - 1)) -
                   b.top;
        lanes_int hit = (b.width >= 0) & (b.height >= 0) & (min_x != STP_OUTSIDE);
        lanes_int small =
            hit & (max_x - min_x < STP_SMALL_EXTENT) & (max_y - min_y < STP_SMALL_EXTENT);
        uint32_t single =
            (lanes_sign_bits(min_x == STP_OUTSIDE) | lanes_sign_bits(hit & ~small)) & valid;
        if ((lanes_sign_bits(small) & valid) != 0) {
            for (int k = 0; k < 3; ++k) {
                b.nearness[k] = (lanes_float)lanes_gather(nearness_words, index[k]);
            }
            draw_batch(window, &b, small, valid, skip_ids(ids, t));
        }
        for (; single != 0; single &= single - 1) {
            draw_lane(chunk, t + (uint32_t)__builtin_ctz(single));
        }
    }
}

static void draw_chunk(stp_triangle_chunk* chunk)
{
    if (chunk->numbers != NULL) {
        draw_chunk_as(chunk, (triangle_ids){chunk->first_id, chunk->numbers});
    } else {
        draw_chunk_as(chunk, (triangle_ids){chunk->first_id, NULL});
    }
}
