// SPDX-License-Identifier: MIT
// The triangle kernels, written for vectors of LANES numbers. Included once by each variant, which
// defines the types lanes_int, lanes_uint, lanes_float and the few operations that need its own
// instructions.
//
// Most triangles of a capture are smaller than a pixel and hit no pixel centre; they leave after
// the test of their bounding box, LANES at a time. Tiny ones are drawn LANES
// triangles at a time, pixel by pixel; larger ones one at a time, LANES pixels of a row at once.
#pragma once

#include "raster/triangles_internal.h"

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
                           (gn >= STP_LEAST_NEARNESS) & (gn <= transform->nearness_limit) &
                           (sw >= STP_LEAST_W);
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

static void find_range(const uint32_t* indices, size_t count, uint32_t* least, uint32_t* most)
{
    uint32_t low = UINT32_MAX, high = 0;
    for (size_t i = 0; i < count; ++i) {
        low = indices[i] < low ? indices[i] : low;
        high = indices[i] > high ? indices[i] : high;
    }
    *least = low;
    *most = high;
}

/// The nearness of small triangles from their edge functions opposite to corners 1 and 2; `along` holds the
/// differences of nearness from corner 0 to these corners.
static inline lanes_float small_nearness(lanes_uint edge1, lanes_uint edge2,
                                         lanes_float inverse_area, lanes_float n0,
                                         const lanes_float along[2], lanes_float low,
                                         lanes_float high)
{
    lanes_float w1 = __builtin_convertvector((lanes_int)edge1, lanes_float);
    lanes_float w2 = __builtin_convertvector((lanes_int)edge2, lanes_float);
    lanes_float nearness = n0 + (w1 * inverse_area) * along[0];
    nearness = nearness + (w2 * inverse_area) * along[1];
    nearness = lanes_select_float(nearness > low, nearness, low);
    return lanes_select_float(nearness < high, nearness, high);
}

/// Pixels whose centres may be inside, ends included.
typedef struct pixel_box {
    int32_t left, right, top, bottom;
} pixel_box;

/// A small triangle, walked in lines: rows where it is wide, columns where it is high. LANES pixels
/// of a line are looked at together.
typedef struct small_walk {
    lanes_uint at[3];    ///< edge functions with bias at the first LANES pixels of a line
    uint32_t onwards[3]; ///< from there to the next LANES pixels
    uint32_t across[3];  ///< from line to line
    uint32_t bias[3];
    lanes_float n0, along[2], inverse_area, low, high;
} small_walk;

/// Columns pay where rows would fill a quarter of a vector at most: their pixels are written one by one.
static inline bool goes_in_columns(const pixel_box* box)
{
    int32_t width = box->right - box->left;
    return width < TINY_WIDTH && box->bottom - box->top > width;
}

/// Edge k, opposite to corner k: its value with bias at the box's first pixel, and its extent.
static inline void set_edge(small_walk* walk, int k, uint32_t first, uint32_t dx, uint32_t dy,
                            uint32_t bias, bool in_columns)
{
    uint32_t step_x = 0U - dy * STP_SUBPIXEL, step_y = dx * STP_SUBPIXEL;
    uint32_t step = in_columns ? step_y : step_x;
    walk->at[k] = (lanes_uint)lanes_index() * step + first;
    walk->onwards[k] = step * LANES;
    walk->across[k] = in_columns ? step_x : step_y;
    walk->bias[k] = bias;
}

static inline lanes_int walk_nearness(const small_walk* walk, lanes_uint edge1, lanes_uint edge2)
{
    return (lanes_int)small_nearness(edge1 - walk->bias[1], edge2 - walk->bias[2],
                                     walk->inverse_area, walk->n0, walk->along, walk->low,
                                     walk->high);
}

static void draw_rows(const stp_triangle_window* window, const pixel_box* box,
                      const small_walk* start, uint32_t id)
{
    small_walk walk = *start; // a copy that no store of pixels can touch
    uint64_t fragments = 0;
    for (int32_t row = box->top; row <= box->bottom; ++row) {
        uint64_t* pixels = stp_triangle_row(window, row);
        lanes_uint e0 = walk.at[0], e1 = walk.at[1], e2 = walk.at[2];
        for (int32_t column = box->left; column <= box->right; column += LANES) {
            lanes_int inside = ~(lanes_int)(e0 | e1 | e2) & (column + lanes_index() <= box->right);
            uint32_t bits = lanes_sign_bits(inside);
            if (bits != 0) {
                lanes_write(pixels + column, bits, walk_nearness(&walk, e1, e2), id);
                fragments += (uint64_t)__builtin_popcount(bits);
            }
            e0 += walk.onwards[0];
            e1 += walk.onwards[1];
            e2 += walk.onwards[2];
        }
        for (int k = 0; k < 3; ++k) {
            walk.at[k] += walk.across[k];
        }
    }
    *window->fragments += fragments;
}

/// Like lanes_write, but down a column.
static inline void write_column(uint64_t* pixels, size_t stride, uint32_t bits, lanes_int nearness,
                                uint32_t id)
{
    int32_t depth[LANES];
    memcpy(depth, &nearness, sizeof(depth));
    for (; bits != 0; bits &= bits - 1) {
        size_t lane = (size_t)__builtin_ctz(bits);
        uint64_t pixel = (uint64_t) ~(uint32_t)depth[lane] << 32 | id;
        uint64_t* place = pixels + lane * stride;
        *place = pixel < *place ? pixel : *place;
    }
}

static void draw_columns(const stp_triangle_window* window, const pixel_box* box,
                         const small_walk* start, uint32_t id)
{
    small_walk walk = *start; // a copy that no store of pixels can touch
    for (int32_t column = box->left; column <= box->right; ++column) {
        lanes_uint e0 = walk.at[0], e1 = walk.at[1], e2 = walk.at[2];
        for (int32_t row = box->top; row <= box->bottom; row += LANES) {
            lanes_int inside = ~(lanes_int)(e0 | e1 | e2) & (row + lanes_index() <= box->bottom);
            uint32_t bits = lanes_sign_bits(inside);
            if (bits != 0) {
                write_column(stp_triangle_row(window, row) + column, window->stride, bits,
                             walk_nearness(&walk, e1, e2), id);
                *window->fragments += (uint64_t)__builtin_popcount(bits);
            }
            e0 += walk.onwards[0];
            e1 += walk.onwards[1];
            e2 += walk.onwards[2];
        }
        for (int k = 0; k < 3; ++k) {
            walk.at[k] += walk.across[k];
        }
    }
}

static inline void draw_walk(const stp_triangle_window* window, const pixel_box* box,
                             const small_walk* walk, uint32_t id)
{
    if (goes_in_columns(box)) {
        draw_columns(window, box, walk, id);
    } else {
        draw_rows(window, box, walk, id);
    }
}

/// A small triangle by itself.
static void draw_small(const stp_triangle_window* window, const stp_triangle_setup* setup,
                       uint32_t id)
{
    pixel_box box = {setup->left, setup->right, setup->top, setup->bottom};
    small_walk walk;
    for (int k = 0; k < 3; ++k) {
        stp_triangle_edge edge =
            stp_triangle_edge_make(setup->corner[(k + 1) % 3], setup->corner[(k + 2) % 3]);
        int64_t first = stp_triangle_edge_at(&edge, setup->left, setup->top) + edge.bias;
        set_edge(&walk, k, (uint32_t)first, (uint32_t)edge.dx, (uint32_t)edge.dy,
                 (uint32_t)edge.bias, goes_in_columns(&box));
    }
    const lanes_float zero = {0};
    float n0 = setup->corner[0].nearness;
    walk.n0 = zero + n0;
    walk.along[0] = zero + (setup->corner[1].nearness - n0);
    walk.along[1] = zero + (setup->corner[2].nearness - n0);
    walk.inverse_area = zero + 1.0f / (float)setup->area;
    walk.low = zero + setup->low;
    walk.high = zero + setup->high;
    draw_walk(window, &box, &walk, id);
}

static void draw_large(const stp_triangle_window* window, const stp_triangle_setup* setup,
                       uint32_t id)
{
    stp_triangle_edge edges[3];
    for (int k = 0; k < 3; ++k) {
        edges[k] = stp_triangle_edge_make(setup->corner[k], setup->corner[(k + 1) % 3]);
    }
    stp_triangle_plane plane = stp_triangle_plane_make(setup);
    const lanes_float zero = {0};
    float low = setup->low, high = setup->high;
    const lanes_float lowest = zero + low, highest = zero + high;
    const lanes_double steps = __builtin_convertvector(lanes_index(), lanes_double);
    uint64_t fragments = 0;
    for (int32_t row = setup->top; row <= setup->bottom; ++row) {
        int64_t first = setup->left, last = setup->right;
        for (int k = 0; k < 3; ++k) {
            stp_triangle_edge_narrow(&edges[k], row, &first, &last);
        }
        uint64_t* pixels = stp_triangle_row(window, row);
        double row_nearness = stp_triangle_plane_row(&plane, row);
        for (int64_t column = first; column <= last; column += LANES) { // as stp_triangle_plane_at
            lanes_double x = (steps + (double)column) * (double)STP_SUBPIXEL;
            x += (double)STP_SUBPIXEL_HALF;
            lanes_double at = row_nearness + plane.along_x * (x - plane.x);
            lanes_float nearness = __builtin_convertvector(at, lanes_float);
            nearness = lanes_select_float(nearness > low, nearness, lowest);
            nearness = lanes_select_float(nearness < high, nearness, highest);
            int64_t left = last - column + 1;
            uint32_t bits = left < LANES ? (1U << left) - 1 : LANES_ALL;
            lanes_write(pixels + column, bits, (lanes_int)nearness, id);
        }
        fragments += last < first ? 0 : (uint64_t)(last - first) + 1;
    }
    *window->fragments += fragments;
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

/// LANES triangles: corners in sub-pixels, and the pixels their boxes hold.
typedef struct batch {
    lanes_int x[3], y[3];
    lanes_int left, top, width, height; ///< of the box in pixels, less one
    lanes_float nearness[3];
} batch;

/// LANES small triangles ready to be drawn, turned so that their areas are positive.
typedef struct batch_setup {
    lanes_uint at[3]; ///< edge functions with bias at the first pixel of the box
    lanes_uint dx[3], dy[3], bias[3];
    lanes_float n0, along[2], inverse_area, low, high;
} batch_setup;

/// Sets up all lanes. @return the lanes whose triangles have an area
static inline lanes_int set_up_batch(const batch* b, batch_setup* setup)
{
    lanes_uint x0 = (lanes_uint)b->x[0], y0 = (lanes_uint)b->y[0];
    lanes_uint x1 = (lanes_uint)b->x[1] - x0, y1 = (lanes_uint)b->y[1] - y0;
    lanes_uint x2 = (lanes_uint)b->x[2] - x0, y2 = (lanes_uint)b->y[2] - y0;
    lanes_int area = (lanes_int)(x1 * y2 - y1 * x2);
    lanes_int has_area = area != 0, turned = area < 0;
    area = lanes_select(turned, -area, area);
    lanes_uint ux1 = (lanes_uint)lanes_select(turned, (lanes_int)x2, (lanes_int)x1);
    lanes_uint uy1 = (lanes_uint)lanes_select(turned, (lanes_int)y2, (lanes_int)y1);
    lanes_uint ux2 = (lanes_uint)lanes_select(turned, (lanes_int)x1, (lanes_int)x2);
    lanes_uint uy2 = (lanes_uint)lanes_select(turned, (lanes_int)y1, (lanes_int)y2);
    // edges 1 -> 2, 2 -> 0, 0 -> 1: opposite to corners 0, 1, 2
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

/// Writes one pixel of each triangle of `bits`: the same place in each one's box.
static inline void write_lanes(const stp_triangle_window* window, const batch* b, int32_t row,
                               int32_t column, uint32_t bits, lanes_float nearness,
                               uint32_t first_id)
{
    float depth[LANES];
    memcpy(depth, &nearness, sizeof(depth));
    *window->fragments += (uint64_t)__builtin_popcount(bits);
    for (; bits != 0; bits &= bits - 1) {
        uint32_t lane = (uint32_t)__builtin_ctz(bits);
        uint64_t* place = stp_triangle_row(window, b->top[lane] + row) + b->left[lane] + column;
        uint64_t pixel = stp_raster_pixel(depth[lane], first_id + lane);
        *place = pixel < *place ? pixel : *place;
    }
}

/// Draws the triangles of `alive` (sign bits), none wider than TINY_WIDTH or higher than TINY_HEIGHT
/// pixels: pixel by pixel of their boxes, all triangles at once.
static void draw_tiny(const stp_triangle_window* window, const batch* b, batch_setup* setup,
                      lanes_int alive, uint32_t first_id)
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
                write_lanes(window, b, row, column, bits, nearness, first_id);
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
static void draw_medium(const stp_triangle_window* window, const batch* b, const batch_setup* setup,
                        uint32_t lanes, uint32_t first_id)
{
    const lanes_float zero = {0};
    for (; lanes != 0; lanes &= lanes - 1) {
        int lane = __builtin_ctz(lanes);
        pixel_box box = {b->left[lane], b->left[lane] + b->width[lane], b->top[lane],
                         b->top[lane] + b->height[lane]};
        small_walk walk = {
            .n0 = zero + setup->n0[lane],
            .along = {zero + setup->along[0][lane], zero + setup->along[1][lane]},
            .inverse_area = zero + setup->inverse_area[lane],
            .low = zero + setup->low[lane],
            .high = zero + setup->high[lane],
        };
        for (int k = 0; k < 3; ++k) {
            set_edge(&walk, k, setup->at[k][lane], setup->dx[k][lane], setup->dy[k][lane],
                     setup->bias[k][lane], goes_in_columns(&box));
        }
        draw_walk(window, &box, &walk, first_id + (uint32_t)lane);
    }
}

static void draw_batch(const stp_triangle_window* window, const batch* b, lanes_int small,
                       uint32_t valid, uint32_t first_id)
{
    batch_setup setup;
    small &= set_up_batch(b, &setup); // lanes past the end have no area
    lanes_int tiny = small & (b->width < TINY_WIDTH) & (b->height < TINY_HEIGHT);
    draw_medium(window, b, &setup, lanes_sign_bits(small & ~tiny) & valid, first_id);
    if (lanes_sign_bits(tiny) != 0) {
        draw_tiny(window, b, &setup, tiny, first_id);
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
        draw_one(&chunk->window, corners, chunk->first_id + triangle);
    } else if (shared_code == 0) { // else all corners lie beyond one plane
        chunk->clipped[chunk->clipped_count++] = triangle;
    }
}

static void draw_chunk(stp_triangle_chunk* chunk)
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
            draw_batch(window, &b, small, valid, chunk->first_id + t);
        }
        for (; single != 0; single &= single - 1) {
            draw_lane(chunk, t + (uint32_t)__builtin_ctz(single));
        }
    }
}
