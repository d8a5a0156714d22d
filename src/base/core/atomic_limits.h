// SPDX-License-Identifier: MIT
// Atomic minimum and maximum.
#pragma once

#include <stdatomic.h>
#include <stdint.h>

static inline void stp_atomic_min(atomic_uint_fast64_t* minimum, uint64_t value)
{
    uint_fast64_t old = atomic_load(minimum);
    while (value < old && !atomic_compare_exchange_weak(minimum, &old, value)) {
    }
}

static inline void stp_atomic_max(atomic_uint_fast64_t* maximum, uint64_t value)
{
    uint_fast64_t old = atomic_load(maximum);
    while (value > old && !atomic_compare_exchange_weak(maximum, &old, value)) {
    }
}
