// SPDX-License-Identifier: MIT
// Morton codes: interleaved bits of three coordinates, so that close codes are close in space.
#pragma once

#include <stdint.h>

/// Inserts two zero bits before each of the lower ten bits.
static inline uint32_t stp_spread_bits(uint32_t x)
{
    x &= 0x3ffu;
    x = (x | x << 16) & 0x030000ffu;
    x = (x | x << 8) & 0x0300f00fu;
    x = (x | x << 4) & 0x030c30c3u;
    return (x | x << 2) & 0x09249249u;
}

/// Uses the lower ten bits of each coordinate; x has the lowest bit of each three.
static inline uint32_t stp_morton(uint32_t x, uint32_t y, uint32_t z)
{
    return stp_spread_bits(x) | stp_spread_bits(y) << 1 | stp_spread_bits(z) << 2;
}
