// SPDX-License-Identifier: MIT
// Morton codes: the bits of three coordinates in turn, so that numbers near each other are places near each other.
#pragma once

#include <stdint.h>

/// The lower ten bits, two zero bits before each.
static inline uint32_t stp_spread_bits(uint32_t x)
{
    x &= 0x3ffu;
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// Of each coordinate the lower ten bits; x has the lowest bit of each three.
static inline uint32_t stp_morton(uint32_t x, uint32_t y, uint32_t z)
{
    return stp_spread_bits(x) | stp_spread_bits(y) << 1 | stp_spread_bits(z) << 2;
}
