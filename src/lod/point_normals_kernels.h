// SPDX-License-Identifier: MIT
#pragma once

#include "base/math/math.h"

#include <stddef.h>
#include <stdint.h>

enum {
    STP_NORMAL_SUMS = 10,
    STP_NORMAL_MATRIX = 6,
    STP_NEAR_POINTS_MAX = 448, ///< a multiple of 8
};

/// Side of a cell over the radius of the search: slightly larger, to allow for rounding.
#define STP_NORMAL_CELL 1.001f

/// Points that may be near others.
typedef struct stp_near_points {
    uint32_t count; ///< a multiple of 8: padded with points that are infinitely far away
    float x[STP_NEAR_POINTS_MAX], y[STP_NEAR_POINTS_MAX], z[STP_NEAR_POINTS_MAX];
} stp_near_points;

/// Every variant gives the same bits.
typedef struct stp_normal_kernels {
    /// Sums over the points of a list within a distance of a position: count, then offsets x, y, z
    /// and the products xx, xy, xz, yy, yz, zz.
    void (*sum_near)(const stp_near_points* points, float squared_radius, stp_vec3 position,
                     float out[STP_NORMAL_SUMS]);
    /// For each of `count` such sums of at least one point, a symmetric matrix (xx, xy, xz, yy, yz,
    /// zz) that projects every vector onto the direction of least spread.
    void (*project)(const float (*sums)[STP_NORMAL_SUMS], size_t count,
                    float (*out)[STP_NORMAL_MATRIX]);
} stp_normal_kernels;

/// The kernels for this CPU.
const stp_normal_kernels* stp_normal_kernels_select(void);

extern const stp_normal_kernels stp_normal_kernels_portable;
extern const stp_normal_kernels stp_normal_kernels_vector;
