// SPDX-License-Identifier: MIT
// Vectors, boxes and transforms. Uses only addition, subtraction, multiplication, division and
// square root: the bits are the same on every machine, with any compiler and optimisation level.
#pragma once

#include <stipple/types.h>

#include <float.h>
#include <math.h>
#include <stdbool.h>

#define STP_PI 3.14159265358979323846

static inline float stp_min(float a, float b)
{
    return a < b ? a : b;
}

static inline float stp_max(float a, float b)
{
    return a > b ? a : b;
}

static inline float stp_clamp(float x, float low, float high)
{
    return x < low ? low : x > high ? high : x;
}

static inline double stp_maxd(double a, double b)
{
    return a > b ? a : b;
}

static inline double stp_mind(double a, double b)
{
    return a < b ? a : b;
}

/// NaN becomes `low`.
static inline double stp_clampd(double x, double low, double high)
{
    return x > low ? x < high ? x : high : low;
}

static inline stp_vec3 stp_add(stp_vec3 a, stp_vec3 b)
{
    return (stp_vec3){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline stp_vec3 stp_sub(stp_vec3 a, stp_vec3 b)
{
    return (stp_vec3){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline stp_vec3 stp_scale(stp_vec3 a, float factor)
{
    return (stp_vec3){a.x * factor, a.y * factor, a.z * factor};
}

static inline float stp_dot(stp_vec3 a, stp_vec3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline stp_vec3 stp_cross(stp_vec3 a, stp_vec3 b)
{
    return (stp_vec3){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline float stp_length(stp_vec3 a)
{
    return sqrtf(stp_dot(a, a));
}

/// Unit length; (0, 0, 0) if the length is 0 or not finite.
static inline stp_vec3 stp_normalize(stp_vec3 a)
{
    double x = (double)a.x, y = (double)a.y, z = (double)a.z;
    double length = sqrt(x * x + y * y + z * z);
    if (!(length > 0.0) || length > DBL_MAX) {
        return (stp_vec3){0};
    }
    return (stp_vec3){(float)(x / length), (float)(y / length), (float)(z / length)};
}

static inline stp_vec3d stp_addd(stp_vec3d a, stp_vec3d b)
{
    return (stp_vec3d){a.x + b.x, a.y + b.y, a.z + b.z};
}

static inline stp_vec3d stp_subd(stp_vec3d a, stp_vec3d b)
{
    return (stp_vec3d){a.x - b.x, a.y - b.y, a.z - b.z};
}

static inline stp_vec3d stp_scaled(stp_vec3d a, double factor)
{
    return (stp_vec3d){a.x * factor, a.y * factor, a.z * factor};
}

static inline double stp_dotd(stp_vec3d a, stp_vec3d b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

static inline double stp_lengthd(stp_vec3d a)
{
    return sqrt(stp_dotd(a, a));
}

static inline stp_vec3d stp_crossd(stp_vec3d a, stp_vec3d b)
{
    return (stp_vec3d){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

static inline stp_vec3d stp_normalized(stp_vec3d a)
{
    double length = stp_lengthd(a);
    return length > 0.0 ? stp_scaled(a, 1.0 / length) : (stp_vec3d){0};
}

static inline stp_vec3 stp_to_float(stp_vec3d a)
{
    return (stp_vec3){(float)a.x, (float)a.y, (float)a.z};
}

static inline stp_vec3d stp_to_double(stp_vec3 a)
{
    return (stp_vec3d){(double)a.x, (double)a.y, (double)a.z};
}

static inline bool stp_is_finite(stp_vec3 a)
{
    return isfinite(a.x) && isfinite(a.y) && isfinite(a.z);
}

static inline stp_box stp_box_empty(void)
{
    return (stp_box){{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
}

static inline stp_boxd stp_boxd_empty(void)
{
    return (stp_boxd){{DBL_MAX, DBL_MAX, DBL_MAX}, {-DBL_MAX, -DBL_MAX, -DBL_MAX}};
}

static inline bool stp_boxd_is_empty(stp_boxd box)
{
    return box.max.x < box.min.x;
}

static inline void stp_box_add(stp_box* box, stp_vec3 p)
{
    box->min =
        (stp_vec3){stp_min(box->min.x, p.x), stp_min(box->min.y, p.y), stp_min(box->min.z, p.z)};
    box->max =
        (stp_vec3){stp_max(box->max.x, p.x), stp_max(box->max.y, p.y), stp_max(box->max.z, p.z)};
}

/// Box of `count` positions, 3 numbers each; empty if there are none.
static inline stp_box stp_box_of(const float* positions, size_t count)
{
    stp_box box = stp_box_empty();
    for (size_t i = 0; i < count; ++i) {
        const float* p = positions + 3 * i;
        stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
    }
    return box;
}

static inline void stp_boxd_add(stp_boxd* box, stp_vec3d p)
{
    box->min.x = p.x < box->min.x ? p.x : box->min.x;
    box->min.y = p.y < box->min.y ? p.y : box->min.y;
    box->min.z = p.z < box->min.z ? p.z : box->min.z;
    box->max.x = p.x > box->max.x ? p.x : box->max.x;
    box->max.y = p.y > box->max.y ? p.y : box->max.y;
    box->max.z = p.z > box->max.z ? p.z : box->max.z;
}

static inline stp_affine stp_affine_identity(void)
{
    return (stp_affine){{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
}

static inline bool stp_affine_is_identity(const stp_affine* a)
{
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            if (a->m[r][c] != (r == c ? 1.0 : 0.0)) {
                return false;
            }
        }
    }
    return true;
}

/// Applies `b` first, then `a`.
static inline stp_affine stp_affine_multiply(stp_affine a, stp_affine b)
{
    stp_affine out;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            out.m[r][c] = a.m[r][0] * b.m[0][c] + a.m[r][1] * b.m[1][c] + a.m[r][2] * b.m[2][c] +
                          (c == 3 ? a.m[r][3] : 0.0);
        }
    }
    return out;
}

static inline stp_vec3d stp_affine_point(const stp_affine* a, stp_vec3d p)
{
    return (stp_vec3d){
        a->m[0][0] * p.x + a->m[0][1] * p.y + a->m[0][2] * p.z + a->m[0][3],
        a->m[1][0] * p.x + a->m[1][1] * p.y + a->m[1][2] * p.z + a->m[1][3],
        a->m[2][0] * p.x + a->m[2][1] * p.y + a->m[2][2] * p.z + a->m[2][3],
    };
}

static inline double stp_affine_determinant(const stp_affine* a)
{
    return a->m[0][0] * (a->m[1][1] * a->m[2][2] - a->m[1][2] * a->m[2][1]) -
           a->m[0][1] * (a->m[1][0] * a->m[2][2] - a->m[1][2] * a->m[2][0]) +
           a->m[0][2] * (a->m[1][0] * a->m[2][1] - a->m[1][1] * a->m[2][0]);
}

/// How the corners of a triangle's front turn in a picture whose rows go down, if they turn
/// counter-clockwise before the transform: -1 counter-clockwise, 1 clockwise. 0: it is flat.
static inline int32_t stp_affine_front_turn(const stp_affine* a)
{
    double determinant = stp_affine_determinant(a);
    return determinant > 0.0 ? -1 : determinant < 0.0 ? 1 : 0;
}

/// Upper bound on the length of a transformed unit vector. Exact for rotations and uniform scales;
/// stp_affine_stretch is tighter and slower.
static inline double stp_affine_scale(const stp_affine* a)
{
    // the longest column is exact for rotations and uniform scales; otherwise use the Frobenius
    // norm
    double column = 0.0, sum = 0.0, shear = 0.0;
    for (int c = 0; c < 3; ++c) {
        int next = (c + 1) % 3;
        double square = a->m[0][c] * a->m[0][c] + a->m[1][c] * a->m[1][c] + a->m[2][c] * a->m[2][c];
        double dot =
            a->m[0][c] * a->m[0][next] + a->m[1][c] * a->m[1][next] + a->m[2][c] * a->m[2][next];
        column = square > column ? square : column;
        shear = fabs(dot) > shear ? fabs(dot) : shear;
        sum += square;
    }
    bool uniform = sum >= 3.0 * column * (1.0 - 1e-9) && shear <= 1e-9 * column;
    return sqrt(uniform ? column : sum);
}

/// Whether a transform only rotates, mirrors, moves and scales alike in all directions, to 0.0001.
static inline bool stp_affine_is_similarity(const stp_affine* a)
{
    double most = 0.0, least = HUGE_VAL, shear = 0.0;
    for (int c = 0; c < 3; ++c) {
        int next = (c + 1) % 3;
        double square = a->m[0][c] * a->m[0][c] + a->m[1][c] * a->m[1][c] + a->m[2][c] * a->m[2][c];
        double dot =
            a->m[0][c] * a->m[0][next] + a->m[1][c] * a->m[1][next] + a->m[2][c] * a->m[2][next];
        most = square > most ? square : most;
        least = square < least ? square : least;
        shear = fabs(dot) > shear ? fabs(dot) : shear;
    }
    return most - least <= 1e-4 * most && shear <= 1e-4 * most;
}

/// Matrix that transforms normals: the cofactors of the linear part. Needs no division and keeps
/// the side under mirroring. Results are not of unit length.
static inline void stp_affine_normal_matrix(const stp_affine* a, double out[3][3])
{
    double sign = stp_affine_determinant(a) < 0.0 ? -1.0 : 1.0;
    for (int r = 0; r < 3; ++r) {
        int r1 = (r + 1) % 3, r2 = (r + 2) % 3;
        for (int c = 0; c < 3; ++c) {
            int c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[r][c] = sign * (a->m[r1][c1] * a->m[r2][c2] - a->m[r1][c2] * a->m[r2][c1]);
        }
    }
}

/// Factor by which a transform scales areas: exact for uniform scales, else the mean over the three
/// coordinate planes.
static inline double stp_affine_area_scale(const stp_affine* a)
{
    double cofactors[3][3], sum = 0.0;
    stp_affine_normal_matrix(a, cofactors);
    for (int c = 0; c < 3; ++c) {
        double x = cofactors[0][c], y = cofactors[1][c], z = cofactors[2][c];
        sum += sqrt(x * x + y * y + z * z);
    }
    return sum / 3.0;
}

/// Same transform, relative to `origin` in the target space.
static inline stp_affine stp_affine_shifted(stp_affine a, stp_vec3d origin)
{
    a.m[0][3] -= origin.x;
    a.m[1][3] -= origin.y;
    a.m[2][3] -= origin.z;
    return a;
}

/// Bounding box of the transformed box.
static inline stp_boxd stp_affine_box(const stp_affine* a, stp_boxd box)
{
    stp_boxd out = stp_boxd_empty();
    for (int corner = 0; !stp_boxd_is_empty(box) && corner < 8; ++corner) {
        stp_vec3d p = {(corner & 1) != 0 ? box.max.x : box.min.x,
                       (corner & 2) != 0 ? box.max.y : box.min.y,
                       (corner & 4) != 0 ? box.max.z : box.min.z};
        stp_boxd_add(&out, stp_affine_point(a, p));
    }
    return out;
}

// Largest scale factor of a transform.

/// Largest factor by which a transform stretches a length: never too small, at most 1 % too large,
/// and exact for rotations, mirroring and uniform scales. 0 if it collapses everything to a point
/// or is not finite.
double stp_affine_stretch(const stp_affine* a);

// Sine and cosine from basic arithmetic only, so the bits are the same on every machine. C
// libraries do not promise that.

/// `angle` is in radians, up to 10^6 in size; the error is below 10^-15. Both results are NaN for
/// larger or non-finite angles.
static inline void stp_sine_cosine(double angle, double* sine, double* cosine)
{
    // quarter turn split in two parts: products of the first part with integers are exact
    static const double quarter_high = 1.57079632673412561417e+00,
                        quarter_low = 6.07710050650619224932e-11;
    if (!(fabs(angle) <= 1e6)) {
        *sine = *cosine = (double)NAN;
        return;
    }
    double turns = floor(angle * 0.63661977236758134308 + 0.5);
    double x = angle - turns * quarter_high - turns * quarter_low, square = x * x;
    double s = 1.0, c = 1.0;
    for (int i = 9; i >= 1; --i) { // Taylor series: the first omitted term is below 10^-17
        s = 1.0 - s * square / (double)((2 * i) * (2 * i + 1));
        c = 1.0 - c * square / (double)((2 * i - 1) * (2 * i));
    }
    s *= x;
    int quarter = (int)turns & 3;
    double a = (quarter & 1) != 0 ? c : s, b = (quarter & 1) != 0 ? s : c;
    *sine = quarter >= 2 ? -a : a;
    *cosine = quarter == 1 || quarter == 2 ? -b : b;
}
