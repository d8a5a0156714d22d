// SPDX-License-Identifier: MIT
//
// Plain values: vectors, boxes, transforms. Right-handed axes; y is up inside the library.
#pragma once

#include <stipple/base.h>

typedef struct stp_vec2 {
    float x, y;
} stp_vec2;

typedef struct stp_vec3 {
    float x, y, z;
} stp_vec3;

typedef struct stp_vec3d {
    double x, y, z;
} stp_vec3d;

/// An axis-aligned box. Empty where max < min.
typedef struct stp_box {
    stp_vec3 min, max;
} stp_box;

typedef struct stp_boxd {
    stp_vec3d min, max;
} stp_boxd;

/// A linear map and a translation: out = m * (x, y, z, 1); three rows of four.
typedef struct stp_affine {
    double m[3][4];
} stp_affine;
