// SPDX-License-Identifier: MIT
//
// Whether triangles form a closed surface, and which way it faces. Each directed edge adds a random
// number of the edge, or subtracts it for the other direction. The sum is zero if all edges cancel;
// for an open surface that happens with probability 2^-64. So edges need not be stored, and the
// sums of pieces add up to the sum of the whole.
#pragma once

#include "base/math/math.h"
#include "base/math/rng.h"

#include <string.h>

/// Sums over the triangles added so far. All zero at the beginning.
typedef struct stp_closed_surface {
    uint64_t edges;
    double volume; ///< six times the signed volume
    double terms;  ///< the sum of the absolute values that volume is the sum of
} stp_closed_surface;

/// Sign of a signed volume; 0: none, up to rounding. Coordinates are floats, so a closed surface
/// with a volume has more than this share of the terms, however far from the origin.
static inline int stp_volume_sign(double volume, double terms)
{
    return !(fabs(volume) > 1e-9 * terms) ? 0 : volume > 0.0 ? 1 : -1;
}

/// Hash of a position; -0 equals 0.
static inline uint64_t stp_corner_hash(const float p[3])
{
    uint64_t hash = 11;
    for (int k = 0; k < 3; ++k) {
        float x = p[k] + 0.0f; // -0 is 0
        uint32_t bits;
        memcpy(&bits, &x, sizeof(bits));
        hash = stp_rng_hash(hash, bits);
    }
    return hash;
}

static inline void stp_closed_surface_add(stp_closed_surface* surface,
                                          const float* const corners[3])
{
    uint64_t hash[3];
    stp_vec3d p[3];
    for (int k = 0; k < 3; ++k) {
        hash[k] = stp_corner_hash(corners[k]);
        p[k] = (stp_vec3d){(double)corners[k][0], (double)corners[k][1], (double)corners[k][2]};
    }
    for (int k = 0; k < 3; ++k) {
        uint64_t from = hash[k], to = hash[(k + 1) % 3];
        uint64_t number = stp_rng_hash(from + to, from ^ to);
        surface->edges += from < to ? number : from > to ? (uint64_t)0 - number : 0;
    }
    double term = stp_dotd(p[0], stp_crossd(p[1], p[2]));
    surface->volume += term;
    surface->terms += fabs(term);
}

/// 1: closed, and its triangles face outwards; -1: closed, and they face inwards; 0: open, or
/// without volume.
static inline int stp_closed_surface_side(const stp_closed_surface* surface)
{
    return surface->edges != 0 ? 0 : stp_volume_sign(surface->volume, surface->terms);
}
