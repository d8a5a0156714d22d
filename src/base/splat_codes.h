// SPDX-License-Identifier: MIT
//
// Codes of the optional columns of a set of splats (docs/format.md, Shapes and ranges). A code decodes by a shift, so that
// every kernel and shader gets the same bits; rounding never makes a splat smaller, nor a range narrower.
//
//   shape   bits 0-11 the larger radius, 12-23 the smaller one, 24-31 the direction of the larger one; of a disk, which has no
//           direction, how far the normals of what it stands for may lie from its own: a sine, 255 is 1 or any. In sets that
//           tell which splats large triangles replace, bit 31 of a disk says so, and a sine of 127 is 1 or any
//   range   bits 0-15 the lowest level at which the splat is drawn, 16-31 the highest
#pragma once

#include "base/math.h"

#include <string.h>

enum {
    STP_SHAPE_NOT_FINITE = 0xFFF,     ///< no radius
    STP_SHAPE_BIAS = 125 << 23,       ///< a radius of code 0 is a quarter of the set's step
    STP_SHAPE_SPREAD_ANY = 127,       ///< any normal
    STP_RANGE_ANY = (int)0xFF000000u, ///< all levels
    STP_RANGE_INFINITE = 0xFF00,      ///< larger codes are no levels
};

#define STP_SHAPE_TURN 256u            ///< directions of half a turn
#define STP_SHAPE_REPLACED 0x80000000u ///< of a disk

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

/// A radius in steps of its set, by its twelve bits: at most 0.8 % too large.
static inline float stp_shape_radius(uint32_t code)
{
    return stp_float_of_bits((code << 16) + (uint32_t)STP_SHAPE_BIAS);
}

/// The code of a radius in steps, rounded up; up to 2^29 steps.
static inline uint32_t stp_shape_code(float radius)
{
    if (!(radius > 0.25f)) {
        return 0;
    }
    uint32_t code = (stp_bits_of_float(radius) - (uint32_t)STP_SHAPE_BIAS + 0xFFFFu) >> 16;
    return code < STP_SHAPE_NOT_FINITE ? code : STP_SHAPE_NOT_FINITE - 1;
}

/// A direction in the plane of a disk, of unit length: a Taylor series, alike in every kernel.
typedef struct stp_shape_axis {
    float along_x, along_y; ///< the disk's axes (base/coverage.h)
} stp_shape_axis;

/// The direction of the smaller radius: a quarter of a turn from that of the larger one.
static inline stp_shape_axis stp_shape_smaller(uint32_t code)
{
    double turn = 3.14159265358979323846 / (double)STP_SHAPE_TURN;
    double x = turn * (double)((code >> 24) & 255u) - 0.5 * 3.14159265358979323846, s = x * x;
    double sine = x, cosine = 1.0, power = 1.0;
    for (int k = 1; k < 10; ++k) { // x is at most a quarter of a turn
        power *= -s / (double)((2 * k - 1) * (2 * k));
        cosine += power;
        sine += x * power / (double)(2 * k + 1);
    }
    return (stp_shape_axis){(float)cosine,
                            (float)sine}; // x is the direction less a quarter of a turn
}

/// What the square of an offset along the smaller radius counts more than along the larger one: 0 of disks.
static inline float stp_shape_stretch(uint32_t code)
{
    float ratio = stp_shape_radius(code & 0xFFFu) / stp_shape_radius(code >> 12 & 0xFFFu);
    return ratio * ratio - 1.0f;
}

/// Of a disk in a set that tells which splats large triangles replace.
/// @param spread sine of how far the normals of what it stands for lie from its own, of STP_SHAPE_SPREAD_ANY
static inline uint32_t stp_shape_disk(float radius, uint32_t spread, bool replaced)
{
    uint32_t code = stp_shape_code(radius);
    return code | code << 12 | spread << 24 | (replaced ? STP_SHAPE_REPLACED : 0u);
}

static inline bool stp_shape_is_disk(uint32_t code)
{
    return (code & 0xFFFu) == (code >> 12 & 0xFFFu);
}

/// That sine, 0 to 1; of an ellipse any normal may be below it.
/// @param tells whether the set tells which splats large triangles replace
static inline float stp_shape_spread(uint32_t code, bool tells)
{
    if (!stp_shape_is_disk(code)) {
        return 1.0f;
    }
    return tells
               ? (float)(code >> 24 & (uint32_t)STP_SHAPE_SPREAD_ANY) / (float)STP_SHAPE_SPREAD_ANY
               : (float)(code >> 24) / 255.0f;
}

/// Whether large triangles replace a splat of a set that tells so.
static inline bool stp_shape_is_replaced(uint32_t code)
{
    return stp_shape_is_disk(code) && (code & STP_SHAPE_REPLACED) != 0;
}

/// By its sixteen bits.
static inline float stp_range_level(uint32_t code)
{
    return stp_float_of_bits(code << 15);
}

/// Levels from `lowest`, rounded down, to `highest`, rounded up; both at least 0, perhaps infinite.
static inline uint32_t stp_range_code(float lowest, float highest)
{
    uint32_t low = stp_bits_of_float(lowest) >> 15;
    uint32_t high = (stp_bits_of_float(highest) + 0x7FFFu) >> 15;
    return low | (high < STP_RANGE_INFINITE ? high : STP_RANGE_INFINITE) << 16;
}

static inline bool stp_range_is_valid(uint32_t code)
{
    return (code & 0xFFFFu) <= code >> 16 && code >> 16 <= STP_RANGE_INFINITE;
}

/// Radii that are finite, the larger one first.
static inline bool stp_shape_is_valid(uint32_t code)
{
    uint32_t larger = code & 0xFFFu, smaller = code >> 12 & 0xFFFu;
    return larger != STP_SHAPE_NOT_FINITE && smaller <= larger;
}
