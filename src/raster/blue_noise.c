// SPDX-License-Identifier: MIT
#include "raster/blue_noise.h"

#include "base/math/rng.h"
#include "raster/blue_noise_table.h"

#include <assert.h>

const uint16_t* const stp_blue_noise = blue_noise_ranks;

uint32_t stp_blue_noise_key(uint32_t seed, uint32_t side, int32_t cell)
{
    assert(side < 6 && "axis and sign of a normal");
    return (uint32_t)(stp_rng_hash(seed, (uint64_t)side << 32 | (uint32_t)cell) >> 40);
}

float stp_blue_noise_threshold(uint32_t key, uint32_t x, uint32_t y, uint32_t sample)
{
    const uint32_t mask = STP_BLUE_NOISE_SIDE - 1;
    uint32_t column = (x + key) & mask, row = (y + (key >> 6)) & mask;
    uint32_t rank = blue_noise_ranks[row * STP_BLUE_NOISE_SIDE + column];
    uint32_t step = (key >> 9 & 0x7FFF) * 2 + 1; // per surface: they are independent
    return (float)((rank * 16 + 8 + sample * step) & 0xFFFF) * (1.0f / 65536.0f);
}
