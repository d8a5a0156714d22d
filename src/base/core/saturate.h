// SPDX-License-Identifier: MIT
// Sums and products of counts that stay at the largest number instead of wrapping around.
#pragma once

#include <stdint.h>

static inline uint64_t stp_add_saturated(uint64_t a, uint64_t b)
{
    return a > UINT64_MAX - b ? UINT64_MAX : a + b;
}

static inline uint64_t stp_multiply_saturated(uint64_t a, uint64_t b)
{
    return b != 0 && a > UINT64_MAX / b ? UINT64_MAX : a * b;
}
