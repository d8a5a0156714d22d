// SPDX-License-Identifier: MIT
//
// Which part of a splat's disk is drawn, in one byte: all of it, a share of its pixels, the part
// on one side of a line, or the strip between two parallel lines. A disk at the border of a plate,
// or on a wire or beam, is clipped to it: it neither protrudes nor leaves a gap. A disk over
// scattered geometry such as leaves has holes.
#pragma once

#include "base/math/math.h"

enum {
    STP_COVERAGE_CHANCES = 39, ///< smaller codes: a share of the pixels
    /// From here on: one line, 24 directions of 15 degrees, three distances
    STP_COVERAGE_HALVES = 39,
    /// From here on: two lines, 12 directions, twelve pairs of distances
    STP_COVERAGE_STRIPS = 111,
    STP_COVERAGE_WHOLE = 255,
    STP_CLIP_DIRECTIONS = 24,
    STP_CLIP_HALF_OFFSETS = 3,
    STP_CLIP_STRIP_OFFSETS = 12,
};

/// The part of a disk of radius 1 that is drawn: low <= across * x + along * y <= high.
typedef struct stp_disk_clip {
    float across, along; ///< direction, of unit length
    float low, high;
} stp_disk_clip;

/// Whether the code clips a disk.
static inline bool stp_coverage_clips(uint8_t code)
{
    return code >= STP_COVERAGE_HALVES && code < STP_COVERAGE_WHOLE;
}

/// Share of a disk's pixels, of 255, for codes below STP_COVERAGE_CHANCES.
extern const uint8_t stp_coverage_shares[STP_COVERAGE_CHANCES];

/// Codes for the plain shares of 255 in files before version 1.2.
extern const uint8_t stp_coverage_of_plain[256];

/// Share of a disk's pixels that is drawn, of 255; 255 for clipped disks.
static inline uint8_t stp_coverage_share(uint8_t code)
{
    return code < STP_COVERAGE_CHANCES ? stp_coverage_shares[code] : 255;
}

/// Fraction of a disk's area that is drawn, 0 to 1.
float stp_coverage_area(uint8_t code);

/// `code` must clip.
stp_disk_clip stp_coverage_clip(uint8_t code);
/// Code for a share of a disk's pixels, 0 to 1. Never a code that draws nothing.
uint8_t stp_coverage_of_share(double share);

/// Unit axes x and y of a disk's plane, from the octahedral code of its normal (integers, -127 to
/// 127).
typedef struct stp_disk_axes {
    stp_vec3 x, y;
} stp_disk_axes;

/// Normal of an octahedral code, not normalised.
static inline stp_vec3 stp_octahedral_unfold(float u, float v)
{
    float z = (127.0f - fabsf(u)) - fabsf(v);
    float fold = z < 0.0f ? -z : 0.0f;
    return (stp_vec3){u + (u >= 0.0f ? -fold : fold), v + (v >= 0.0f ? -fold : fold), z};
}

/// Axes perpendicular to a unit normal. After Duff et al. Building an Orthonormal Basis, Revisited.
/// 2017.
static inline stp_disk_axes stp_disk_axes_across(stp_vec3 n)
{
    float side = n.z < 0.0f ? -1.0f : 1.0f;
    float a = -1.0f / (side + n.z), b = (n.x * n.y) * a;
    return (stp_disk_axes){{1.0f + (side * (n.x * n.x)) * a, side * b, -(side * n.x)},
                           {b, side + (n.y * n.y) * a, -n.y}};
}

static inline stp_disk_axes stp_disk_axes_of(float u, float v)
{
    stp_vec3 n = stp_octahedral_unfold(u, v);
    float inverse = 1.0f / sqrtf((n.x * n.x + n.y * n.y) + n.z * n.z);
    return stp_disk_axes_across((stp_vec3){n.x * inverse, n.y * inverse, n.z * inverse});
}
