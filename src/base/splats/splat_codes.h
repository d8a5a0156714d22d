// SPDX-License-Identifier: MIT
//
// Codes of the optional columns of a splat set (docs/format.md, Blocks). Decoding is a bit shift,
// so every kernel and shader gets the same bits. Rounding never makes a splat smaller or a range
// narrower.
//
//   shape   bits 0-11: larger radius; 12-23: smaller radius; 24-31: direction of the larger one.
//           A disk has no direction. Its bits 24-31 hold the normal spread instead: the sine of the
//           maximum deviation of the replaced surface's normals; 255: 1 or unbounded.
//           In sets that mark splats replaced by large triangles, bit 31 of a disk is that mark,
//           and a spread of 127 means 1 or unbounded.
//   range   bits 0-15: lowest level at which the splat is drawn; 16-31: highest.
//   errors  split errors (Dachsbacher et al. 2003, 3.5): by which shares a view direction lowers
// the           two levels of the range. Bits 0-3: share of the lowest level seen along the disk
//           (perpendicular error); 4-7: seen along the normal (tangential error); 8-11 and 12-15:
//           shares of the highest level, which depends on the parent's disk; 16-31: the parent's
//           normal, octahedral. A share q means (q + 5) / 20.
#pragma once

#include "base/math/math.h"

#include <assert.h>
#include <string.h>

enum {
    STP_SHAPE_NOT_FINITE = 0xFFF,     ///< invalid radius
    STP_SHAPE_BIAS = 125 << 23,       ///< a radius of code 0 is a quarter of the set's step
    STP_SHAPE_SPREAD_ANY = 127,       ///< unbounded, in sets that mark replaced splats
    STP_RANGE_ANY = (int)0xFF000000u, ///< all levels
    STP_RANGE_INFINITE = 0xFF00,      ///< larger codes are invalid levels
};

#define STP_SHAPE_TURN 256u            ///< directions per half turn
#define STP_SHAPE_REPLACED 0x80000000u ///< bit of a disk that large triangles replace

static inline float stp_float_of_bits(uint32_t bits)
{
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static inline uint32_t stp_bits_of_float(float value)
{
    uint32_t bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

/// Radius in steps of its set, from its twelve bits: at most 0.8 % too large.
static inline float stp_shape_radius(uint32_t code)
{
    return stp_float_of_bits((code << 16) + (uint32_t)STP_SHAPE_BIAS);
}

/// Code of a radius in steps, rounded up; up to 2^29 steps.
static inline uint32_t stp_shape_code(float radius)
{
    if (!(radius > 0.25f)) {
        return 0;
    }
    uint32_t code = (stp_bits_of_float(radius) - (uint32_t)STP_SHAPE_BIAS + 0xFFFFu) >> 16;
    return code < STP_SHAPE_NOT_FINITE ? code : STP_SHAPE_NOT_FINITE - 1;
}

/// Unit direction in the plane of a disk, from a Taylor series: same bits in every kernel.
typedef struct stp_shape_axis {
    float along_x, along_y; ///< the disk's axes (base/splats/coverage.h)
} stp_shape_axis;

/// Direction of the smaller radius: a quarter turn from the larger one.
static inline stp_shape_axis stp_shape_smaller(uint32_t code)
{
    double turn = 3.14159265358979323846 / (double)STP_SHAPE_TURN;
    double x = turn * (double)((code >> 24) & 255u) - 0.5 * 3.14159265358979323846, s = x * x;
    double sine = x, cosine = 1.0, power = 1.0;
    for (int k = 1; k < 10; ++k) { // x: direction minus a quarter turn, at most a quarter turn
        power *= -s / (double)((2 * k - 1) * (2 * k));
        cosine += power;
        sine += x * power / (double)(2 * k + 1);
    }
    return (stp_shape_axis){(float)cosine, (float)sine};
}

/// Extra weight of the square of an offset along the smaller radius; 0 for disks.
static inline float stp_shape_stretch(uint32_t code)
{
    float ratio = stp_shape_radius(code & 0xFFFu) / stp_shape_radius(code >> 12 & 0xFFFu);
    return ratio * ratio - 1.0f;
}

/// Code of a disk in a set that marks splats replaced by large triangles.
/// @param spread normal spread: a sine in units of 1 / STP_SHAPE_SPREAD_ANY
static inline uint32_t stp_shape_disk(float radius, uint32_t spread, bool replaced)
{
    assert(spread <= (uint32_t)STP_SHAPE_SPREAD_ANY && "bit 31 is the mark");
    uint32_t code = stp_shape_code(radius);
    return code | code << 12 | spread << 24 | (replaced ? STP_SHAPE_REPLACED : 0u);
}

static inline bool stp_shape_is_disk(uint32_t code)
{
    return (code & 0xFFFu) == (code >> 12 & 0xFFFu);
}

/// Sine of the normal spread, 0 to 1; the normals of an ellipse may deviate less.
/// @param tells whether the set marks splats replaced by large triangles
static inline float stp_shape_spread(uint32_t code, bool tells)
{
    if (!stp_shape_is_disk(code)) {
        return 1.0f;
    }
    return tells
               ? (float)(code >> 24 & (uint32_t)STP_SHAPE_SPREAD_ANY) / (float)STP_SHAPE_SPREAD_ANY
               : (float)(code >> 24) / 255.0f;
}

/// Whether large triangles replace this splat. Only for sets that mark this.
static inline bool stp_shape_is_replaced(uint32_t code)
{
    return stp_shape_is_disk(code) && (code & STP_SHAPE_REPLACED) != 0;
}

/// Level from its sixteen bits.
static inline float stp_range_level(uint32_t code)
{
    return stp_float_of_bits(code << 15);
}

/// Code of the range from `lowest`, rounded down, to `highest`, rounded up. Both at least 0;
/// infinity is allowed.
static inline uint32_t stp_range_code(float lowest, float highest)
{
    assert(lowest >= 0.0f && highest >= 0.0f);
    uint32_t low = stp_bits_of_float(lowest) >> 15;
    uint32_t high = (stp_bits_of_float(highest) + 0x7FFFu) >> 15;
    return low | (high < STP_RANGE_INFINITE ? high : STP_RANGE_INFINITE) << 16;
}

static inline bool stp_range_is_valid(uint32_t code)
{
    return (code & 0xFFFFu) <= code >> 16 && code >> 16 <= STP_RANGE_INFINITE;
}

/// Whether the radii are finite and the larger one comes first.
static inline bool stp_shape_is_valid(uint32_t code)
{
    uint32_t larger = code & 0xFFFu, smaller = code >> 12 & 0xFFFu;
    return larger != STP_SHAPE_NOT_FINITE && smaller <= larger;
}

enum {
    STP_ERROR_STEPS = 20,       ///< of the share 1
    STP_ERROR_SHARE_FIRST = 5,  ///< steps of the lowest share, which has the code 0
    STP_ERROR_SHARE_WHOLE = 15, ///< code of the share 1
};

/// Code of a share of whole or broken steps, rounded up.
static inline uint32_t stp_error_share_code(double steps)
{
    double code = ceil(steps) - (double)STP_ERROR_SHARE_FIRST;
    assert(!isnan(code));
    code = code > 0.0 ? code : 0.0;
    return code < (double)STP_ERROR_SHARE_WHOLE ? (uint32_t)code : STP_ERROR_SHARE_WHOLE;
}

/// Share of a level that remains in a view, from two codes of shares: that of a disk seen along its
/// plane, and along its normal.
/// @param normal of any length but 0
/// @param sight towards the eye or away from it, of any length
static inline float stp_error_share(uint32_t along_plane, uint32_t along_normal, stp_vec3 normal,
                                    stp_vec3 sight)
{
    float along = fabsf((normal.x * sight.x + normal.y * sight.y) + normal.z * sight.z);
    float square = ((normal.x * normal.x + normal.y * normal.y) + normal.z * normal.z) *
                   ((sight.x * sight.x + sight.y * sight.y) + sight.z * sight.z);
    float cosine = along / sqrtf(square);
    cosine = cosine < 1.0f ? cosine : 1.0f; // also if the eye is at the splat
    float sine = sqrtf(1.0f - cosine * cosine);
    float steps = (float)(int32_t)(along_plane + STP_ERROR_SHARE_FIRST) * sine +
                  (float)(int32_t)(along_normal + STP_ERROR_SHARE_FIRST) * cosine;
    float share = steps * (1.0f / (float)STP_ERROR_STEPS);
    return share < 1.0f ? share : 1.0f;
}
