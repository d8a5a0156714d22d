// SPDX-License-Identifier: MIT
// The sums over the neighbours of points, and what follows from them, several at a time: compiled for processors with
// vectors of 16 and of 32 bytes. Each lane adds its own neighbours, so all variants give the same bits.
//
// Points of one cell have their neighbours in the same 3 x 3 x 3 cells. These are copied once, to where they lie
// together, and every point of the cell looks at all of them.
#pragma once

#include "lod/point_normals_kernels.h"

#include <math.h>
#include <string.h>

_Static_assert(STP_GRID_LANES >= 8, "columns may be read so far beyond their end");

enum {
    LANES = 8,
    FOUR = 4,            ///< doubles at a time
    LIST_SIZE = 1024,    ///< neighbours that are copied at a time
    MOST_TOGETHER = 64,  ///< points of a cell that are looked at together
    MOST_SQUARINGS = 12, ///< of a matrix: its 4096th power
};
#define CONVERGED 1e-12 // what else than the largest eigenvalue leaves of the trace

typedef float lanes_float __attribute__((vector_size(4 * LANES)));
typedef float half_float __attribute__((vector_size(2 * LANES)));
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES)));
typedef double four_double __attribute__((vector_size(8 * FOUR)));
typedef int64_t four_int __attribute__((vector_size(8 * FOUR)));

/// Sums of each lane: how many, x, y, z, xx, xy, xz, yy, yz, zz.
typedef struct lane_sums {
    lanes_float of[STP_NORMAL_SUMS];
} lane_sums;

/// Points that may be neighbours, and the points [begin, begin + count) of the grid that they may be neighbours of.
typedef struct neighbour_list {
    const stp_grid* grid;
    float squared_radius;
    size_t begin, count;
    lane_sums sums[MOST_TOGETHER];
    uint32_t size;
    float x[LIST_SIZE + LANES], y[LIST_SIZE + LANES], z[LIST_SIZE + LANES];
} neighbour_list;

static inline void add_listed(const neighbour_list* list, size_t at, lane_sums* to)
{
    const stp_grid* grid = list->grid;
    const float px = grid->x[at], py = grid->y[at], pz = grid->z[at];
    const lanes_float one = {1, 1, 1, 1, 1, 1, 1, 1};
    lane_sums sums = *to;
    for (uint32_t i = 0; i < list->size; i += LANES) {
        lanes_float x, y, z;
        memcpy(&x, list->x + i, sizeof(x));
        memcpy(&y, list->y + i, sizeof(y));
        memcpy(&z, list->z + i, sizeof(z));
        x -= px;
        y -= py;
        z -= pz;
        lanes_int near = (lanes_int)(x * x + y * y + z * z <= list->squared_radius);
        x = (lanes_float)((lanes_int)x & near);
        y = (lanes_float)((lanes_int)y & near);
        z = (lanes_float)((lanes_int)z & near);
        sums.of[0] += (lanes_float)((lanes_int)one & near);
        sums.of[1] += x;
        sums.of[2] += y;
        sums.of[3] += z;
        sums.of[4] += x * x;
        sums.of[5] += x * y;
        sums.of[6] += x * z;
        sums.of[7] += y * y;
        sums.of[8] += y * z;
        sums.of[9] += z * z;
    }
    *to = sums;
}

/// All points look at what is listed.
static void look_at_list(neighbour_list* list)
{
    for (uint32_t i = 0; i < LANES; ++i) { // far from everything
        list->x[list->size + i] = list->y[list->size + i] = list->z[list->size + i] = INFINITY;
    }
    for (size_t i = 0; i < list->count; ++i) {
        add_listed(list, list->begin + i, &list->sums[i]);
    }
    list->size = 0;
}

/// Copies whole vectors, beyond the end too.
static inline void copy_lanes(float* to, const float* from, uint32_t count)
{
    for (uint32_t i = 0; i < count; i += LANES) {
        memcpy(to + i, from + i, sizeof(lanes_float));
    }
}

static inline void list_points(neighbour_list* list, uint32_t begin, uint32_t end)
{
    const stp_grid* grid = list->grid;
    while (begin < end) {
        uint32_t room = LIST_SIZE - list->size, count = end - begin;
        count = count < room ? count : room;
        copy_lanes(list->x + list->size, grid->x + begin, count);
        copy_lanes(list->y + list->size, grid->y + begin, count);
        copy_lanes(list->z + list->size, grid->z + begin, count);
        list->size += count;
        begin += count;
        if (list->size == LIST_SIZE) {
            look_at_list(list);
        }
    }
}

static void find_cell(const stp_grid* grid, size_t at, int32_t cell[3])
{
    cell[0] = stp_grid_cell(grid, grid->x[at]);
    cell[1] = stp_grid_cell(grid, grid->y[at]);
    cell[2] = stp_grid_cell(grid, grid->z[at]);
}

static inline void prefetch_points(const stp_grid* grid, uint32_t begin)
{
    __builtin_prefetch(grid->x + begin);
    __builtin_prefetch(grid->y + begin);
    __builtin_prefetch(grid->z + begin);
}

/// The 3 x 3 x 3 cells around one. No two of these share a bucket, and those of a row follow each other where they are
/// of one block. All are found before any is read, so that the waits for memory overlap.
static void list_cells(neighbour_list* list, const int32_t cell[3])
{
    enum { MOST = 3 * 3 * 2 };
    const stp_grid* grid = list->grid;
    uint32_t begins[MOST], ends[MOST], count = 0;
    for (int32_t z = cell[2] - 1; z <= cell[2] + 1; ++z) {
        for (int32_t y = cell[1] - 1; y <= cell[1] + 1; ++y) {
            for (int32_t x = cell[0] - 1, last; x <= cell[0] + 1; x = last + 1) {
                last = (x | 3) < cell[0] + 1 ? (x | 3) : cell[0] + 1;
                uint32_t bucket = stp_grid_bucket(grid, x, y, z);
                begins[count] = grid->starts[bucket];
                ends[count] = grid->starts[bucket + (uint32_t)(last - x) + 1];
                prefetch_points(grid, begins[count]);
                count += 1;
            }
        }
    }
    for (uint32_t i = 0; i < count; ++i) {
        list_points(list, begins[i], ends[i]);
    }
    look_at_list(list);
}

static inline void sum_lanes(const lane_sums* sums, float out[STP_NORMAL_SUMS])
{
    for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
        half_float lower, upper;
        memcpy(&lower, &sums->of[i], sizeof(lower));
        memcpy(&upper, (const char*)&sums->of[i] + sizeof(lower), sizeof(upper));
        lower += upper;
        out[i] = (lower[0] + lower[2]) + (lower[1] + lower[3]);
    }
}

static void sum_neighbours(const stp_grid* grid, float radius, size_t begin, size_t end,
                           float (*out)[STP_NORMAL_SUMS])
{
    neighbour_list list;
    list.grid = grid;
    list.squared_radius = radius * radius;
    list.size = 0;
    for (size_t at = begin; at < end; at += list.count) {
        int32_t cell[3], other[3];
        find_cell(grid, at, cell);
        list.begin = at;
        for (list.count = 1; list.count < MOST_TOGETHER && at + list.count < end; ++list.count) {
            find_cell(grid, at + list.count, other);
            if (memcmp(cell, other, sizeof(cell)) != 0) {
                break;
            }
        }
        memset(list.sums, 0, list.count * sizeof(list.sums[0]));
        list_cells(&list, cell);
        for (size_t i = 0; i < list.count; ++i) {
            sum_lanes(&list.sums[i], out[at - begin + i]);
        }
    }
}

/// Four symmetric matrices.
typedef struct four_symmetric {
    four_double xx, xy, xz, yy, yz, zz;
} four_symmetric;

static inline void square(const four_symmetric* m, four_symmetric* out)
{
    *out = (four_symmetric){
        .xx = m->xx * m->xx + m->xy * m->xy + m->xz * m->xz,
        .xy = m->xx * m->xy + m->xy * m->yy + m->xz * m->yz,
        .xz = m->xx * m->xz + m->xy * m->yz + m->xz * m->zz,
        .yy = m->xy * m->xy + m->yy * m->yy + m->yz * m->yz,
        .yz = m->xy * m->xz + m->yy * m->yz + m->yz * m->zz,
        .zz = m->xz * m->xz + m->yz * m->yz + m->zz * m->zz,
    };
}

/// `to` becomes `from`, but for the lanes that are done.
static inline void replace(four_double* to, const four_double* from, const four_int* done)
{
    *to = (four_double)(((four_int)*to & *done) | ((four_int)*from & ~*done));
}

/// Columns of four sums: from the first on, or all the same where there are fewer.
static inline void load_four(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                             four_double out[STP_NORMAL_SUMS])
{
    for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
        double lanes[FOUR];
        for (size_t k = 0; k < FOUR; ++k) {
            lanes[k] = (double)sums[k < count ? k : 0][i];
        }
        memcpy(&out[i], lanes, sizeof(lanes));
    }
}

/// trace I - C, of the covariance C.
static inline void complement_of_covariance(const four_double s[STP_NORMAL_SUMS],
                                            four_symmetric* out)
{
    four_double weight = 1.0 / s[0];
    four_double x = s[1] * weight, y = s[2] * weight, z = s[3] * weight;
    four_double xx = s[4] * weight - x * x, yy = s[7] * weight - y * y;
    four_double zz = s[9] * weight - z * z;
    *out = (four_symmetric){.xx = yy + zz,
                            .xy = -(s[5] * weight - x * y),
                            .xz = -(s[6] * weight - x * z),
                            .yy = xx + zz,
                            .yz = -(s[8] * weight - y * z),
                            .zz = xx + yy};
}

/// Powers of the matrices, of trace 1, turn every column to the eigenvector of the largest eigenvalue: of C it is that of
/// the least. Where only that one is left, the trace of the square is 1. Only products and sums: the same bits everywhere.
static inline void raise_to_power(four_symmetric* m)
{
    four_int done = {0};
    for (int i = 0; i < MOST_SQUARINGS; ++i) {
        four_double trace = m->xx + m->yy + m->zz;
        four_double scale = (four_double)((four_int)(1.0 / trace) & (four_int)(trace > 0.0));
        four_symmetric scaled = {m->xx * scale, m->xy * scale, m->xz * scale,
                                 m->yy * scale, m->yz * scale, m->zz * scale};
        four_symmetric next;
        square(&scaled, &next);
        replace(&m->xx, &next.xx, &done);
        replace(&m->xy, &next.xy, &done);
        replace(&m->xz, &next.xz, &done);
        replace(&m->yy, &next.yy, &done);
        replace(&m->yz, &next.yz, &done);
        replace(&m->zz, &next.zz, &done);
        done |= (four_int)(m->xx + m->yy + m->zz > 1.0 - CONVERGED);
        if ((done[0] & done[1] & done[2] & done[3]) != 0) {
            break;
        }
    }
}

static void project(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                    double (*out)[STP_NORMAL_MATRIX])
{
    for (size_t at = 0; at < count; at += FOUR) {
        size_t left = count - at < FOUR ? count - at : FOUR;
        four_double columns[STP_NORMAL_SUMS];
        load_four(sums + at, left, columns);
        four_symmetric m;
        complement_of_covariance(columns, &m);
        raise_to_power(&m);
        for (size_t k = 0; k < left; ++k) {
            double* to = out[at + k];
            to[0] = m.xx[k], to[1] = m.xy[k], to[2] = m.xz[k];
            to[3] = m.yy[k], to[4] = m.yz[k], to[5] = m.zz[k];
        }
    }
}
