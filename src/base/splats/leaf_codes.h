// SPDX-License-Identifier: MIT
// Codes of the numeric columns of leaves (docs/format.md, Leaves).
#pragma once

#include "base/splats/splat_codes.h"
#include "base/splats/splat_columns.h"

#include <assert.h>

enum { STP_LEAF_EXTENT_SIDE = 64 }; ///< code of a square as wide as the leaf

/// Flatness, 0 to 1/3: the smallest eigenvalue's share of the sum. Eight codes per factor of two,
/// rounded down; 0: too small to represent.
static inline uint8_t stp_leaf_flatness_code(float flatness)
{
    const uint32_t highest = 125u << 3 | 7u; // codes end at 0.47
    uint32_t bits = flatness > 0.0f ? stp_bits_of_float(flatness) >> 20 : 0;
    if (bits + 255u <= highest) {
        return 0;
    }
    return bits < highest ? (uint8_t)(bits + 255u - highest) : 255;
}

static inline float stp_leaf_flatness(uint8_t code)
{
    const uint32_t highest = 125u << 3 | 7u;
    return code == 0 ? 0.0f : stp_float_of_bits((highest - 255u + code) << 20);
}

/// Code of a square's side in units of the leaf's side; the largest is just below 4.
static inline uint8_t stp_leaf_extent_code(float side)
{
    float value = side * (float)STP_LEAF_EXTENT_SIDE + 0.5f;
    return value > 1.0f ? (value < 255.0f ? (uint8_t)value : 255) : 1;
}

static inline uint32_t stp_leaf_depth(const stp_splat_leaf* leaf)
{
    return leaf->place & STP_LEAF_DEPTH;
}

/// Width of a cell at a depth, in grid steps.
static inline uint32_t stp_leaf_width(uint32_t depth)
{
    assert(depth <= STP_LEAF_DEPTH_MAX);
    return 1u << (STP_LEAF_DEPTH_MAX - depth);
}

/// Spreads the bits of a grid coordinate for a Morton code.
static inline uint64_t stp_leaf_spread(uint32_t x)
{
    uint64_t v = x & 0xFFFFu;
    v = (v | v << 16) & UINT64_C(0x0000FF0000FF);
    v = (v | v << 8) & UINT64_C(0x00F00F00F00F);
    v = (v | v << 4) & UINT64_C(0x0C30C30C30C3);
    return (v | v << 2) & UINT64_C(0x249249249249);
}

static inline uint64_t stp_leaf_morton(const uint16_t corner[3])
{
    return stp_leaf_spread(corner[0]) | stp_leaf_spread(corner[1]) << 1 |
           stp_leaf_spread(corner[2]) << 2;
}

/// Surface area in a leaf, in squares of the grid step.
static inline float stp_leaf_area(const stp_splat_leaf* leaf)
{
    float side = (float)stp_leaf_width(stp_leaf_depth(leaf)) * (float)leaf->extent /
                 (float)STP_LEAF_EXTENT_SIDE;
    return side * side;
}
