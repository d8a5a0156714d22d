// SPDX-License-Identifier: MIT
// Sums over the neighbours of points, and normals from these sums, several at a time: compiled for
// CPUs with vectors of 16 and 32 bytes. All variants add the same neighbours in the same order, and
// each lane has a matrix of its own, so they give the same bits.
#pragma once

#include "lod/point_normals_kernels.h"

#include <assert.h>
#include <string.h>

#if defined(__AVX2__)
enum { LANES = 8 };
#else
enum { LANES = 4 };
#endif
enum {
    RESIDUES = 8,       ///< partial sums of a list: one for each residue of the index modulo 8
    MAX_SQUARINGS = 12, ///< squarings of a matrix: its 4096th power
};
/// Twice the share of the other eigenvalues in the trace, before the last squaring squares it
#define CONVERGED 1e-5f

_Static_assert(STP_NEAR_POINTS_MAX % RESIDUES == 0 && RESIDUES % LANES == 0,
               "lists are read in whole vectors");

typedef float lanes_float __attribute__((vector_size(4 * LANES)));
typedef float four_floats __attribute__((vector_size(16)));
typedef int32_t lanes_int __attribute__((vector_size(4 * LANES)));

/// Sums over the points whose indices have the same residues modulo RESIDUES as the lanes from
/// `first` on.
static inline void sum_residues(const stp_near_points* points, uint32_t first, float squared_radius,
                                stp_vec3 position, lanes_float sums[STP_NORMAL_SUMS])
{
    const lanes_float one = (lanes_float){0} + 1.0f;
    for (uint32_t i = first; i < points->count; i += RESIDUES) {
        lanes_float x, y, z;
        memcpy(&x, points->x + i, sizeof(x));
        memcpy(&y, points->y + i, sizeof(y));
        memcpy(&z, points->z + i, sizeof(z));
        x -= position.x;
        y -= position.y;
        z -= position.z;
        lanes_int near = (lanes_int)(x * x + y * y + z * z <= squared_radius);
        x = (lanes_float)((lanes_int)x & near);
        y = (lanes_float)((lanes_int)y & near);
        z = (lanes_float)((lanes_int)z & near);
        sums[0] += (lanes_float)((lanes_int)one & near);
        sums[1] += x;
        sums[2] += y;
        sums[3] += z;
        sums[4] += x * x;
        sums[5] += x * y;
        sums[6] += x * z;
        sums[7] += y * y;
        sums[8] += y * z;
        sums[9] += z * z;
    }
}

/// The sum over all residues.
static inline float total_of(lanes_float (*sums)[STP_NORMAL_SUMS], int i)
{
    four_floats lower, upper;
    const char* last = (const char*)&sums[RESIDUES / LANES - 1][i] + sizeof(lanes_float);
    memcpy(&lower, &sums[0][i], sizeof(lower));
    memcpy(&upper, last - sizeof(upper), sizeof(upper));
    lower += upper;
    return (lower[0] + lower[2]) + (lower[1] + lower[3]);
}

static void sum_near(const stp_near_points* points, float squared_radius, stp_vec3 position,
                     float out[STP_NORMAL_SUMS])
{
    assert(points->count % RESIDUES == 0 && points->count <= STP_NEAR_POINTS_MAX);
    lanes_float sums[RESIDUES / LANES][STP_NORMAL_SUMS] = {{{0}}};
    for (uint32_t part = 0; part < RESIDUES / LANES; ++part) {
        sum_residues(points, part * LANES, squared_radius, position, sums[part]);
    }
    for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
        out[i] = total_of(sums, i);
    }
}

/// Symmetric matrices, one in each lane.
typedef struct lanes_symmetric {
    lanes_float xx, xy, xz, yy, yz, zz;
} lanes_symmetric;

static inline void square(const lanes_symmetric* m, lanes_symmetric* out)
{
    *out = (lanes_symmetric){
        .xx = m->xx * m->xx + m->xy * m->xy + m->xz * m->xz,
        .xy = m->xx * m->xy + m->xy * m->yy + m->xz * m->yz,
        .xz = m->xx * m->xz + m->xy * m->yz + m->xz * m->zz,
        .yy = m->xy * m->xy + m->yy * m->yy + m->yz * m->yz,
        .yz = m->xy * m->xz + m->yy * m->yz + m->yz * m->zz,
        .zz = m->xz * m->xz + m->yz * m->yz + m->zz * m->zz,
    };
}

/// Sets `to` to `from`, except in finished lanes.
static inline void replace(lanes_float* to, const lanes_float* from, const lanes_int* done)
{
    *to = (lanes_float)(((lanes_int)*to & *done) | ((lanes_int)*from & ~*done));
}

/// Whether all lanes are -1.
static inline bool are_all_set(const lanes_int* lanes)
{
    uint64_t parts[LANES / 2];
    memcpy(parts, lanes, sizeof(parts));
    uint64_t all = UINT64_MAX;
    for (int k = 0; k < LANES / 2; ++k) {
        all &= parts[k];
    }
    return all == UINT64_MAX;
}

/// Loads columns of sums; repeats the first one if there are fewer than lanes.
static inline void load_lanes(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                              lanes_float out[STP_NORMAL_SUMS])
{
    float columns[STP_NORMAL_SUMS][LANES];
    assert(count > 0 && count <= LANES);
    for (size_t k = 0; k < LANES; ++k) {
        const float* from = sums[k < count ? k : 0];
        assert(from[0] >= 1.0f && "sums of at least one point");
        for (int i = 0; i < STP_NORMAL_SUMS; ++i) {
            columns[i][k] = from[i];
        }
    }
    memcpy(out, columns, sizeof(columns));
}

/// trace I - C, of the covariance C.
static inline void complement_of_covariance(const lanes_float s[STP_NORMAL_SUMS],
                                            lanes_symmetric* out)
{
    lanes_float weight = 1.0f / s[0];
    lanes_float x = s[1] * weight, y = s[2] * weight, z = s[3] * weight;
    lanes_float xx = s[4] * weight - x * x, yy = s[7] * weight - y * y;
    lanes_float zz = s[9] * weight - z * z;
    *out = (lanes_symmetric){.xx = yy + zz,
                             .xy = -(s[5] * weight - x * y),
                             .xz = -(s[6] * weight - x * z),
                             .yy = xx + zz,
                             .yz = -(s[8] * weight - y * z),
                             .zz = xx + yy};
}

/// Powers of the matrices, of trace 1, turn every column to the eigenvector of the largest
/// eigenvalue: of C it is that of the least. Where only that one is left, the trace of the square
/// is 1. Only products and sums: the same bits everywhere.
static inline void raise_to_power(lanes_symmetric* m)
{
    lanes_int done = {0};
    for (int i = 0; i < MAX_SQUARINGS && !are_all_set(&done); ++i) {
        lanes_float trace = m->xx + m->yy + m->zz;
        lanes_float scale = (lanes_float)((lanes_int)(1.0f / trace) & (lanes_int)(trace > 0.0f));
        lanes_symmetric scaled = {m->xx * scale, m->xy * scale, m->xz * scale,
                                  m->yy * scale, m->yz * scale, m->zz * scale};
        lanes_symmetric next;
        square(&scaled, &next);
        replace(&m->xx, &next.xx, &done);
        replace(&m->xy, &next.xy, &done);
        replace(&m->xz, &next.xz, &done);
        replace(&m->yy, &next.yy, &done);
        replace(&m->yz, &next.yz, &done);
        replace(&m->zz, &next.zz, &done);
        done |= (lanes_int)(m->xx + m->yy + m->zz > 1.0f - CONVERGED);
    }
}

static void project(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                    float (*out)[STP_NORMAL_MATRIX])
{
    for (size_t at = 0; at < count; at += LANES) {
        size_t left = count - at < LANES ? count - at : LANES;
        lanes_float columns[STP_NORMAL_SUMS];
        load_lanes(sums + at, left, columns);
        lanes_symmetric m;
        complement_of_covariance(columns, &m);
        raise_to_power(&m);
        for (size_t k = 0; k < left; ++k) {
            float* to = out[at + k];
            to[0] = m.xx[k], to[1] = m.xy[k], to[2] = m.xz[k];
            to[3] = m.yy[k], to[4] = m.yz[k], to[5] = m.zz[k];
        }
    }
}
