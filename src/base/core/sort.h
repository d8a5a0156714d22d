// SPDX-License-Identifier: MIT
// Radix sort of 64-bit items by some of their bits. Stable; linear time.
#pragma once

#include "base/core/context.h"

#include <stddef.h>
#include <stdint.h>

/// Number of bits up to the highest one that is set: as many as a sort by this value needs.
static inline unsigned stp_bit_width(uint64_t value)
{
    return value != 0 ? 64 - (unsigned)__builtin_clzll(value) : 0;
}

/// Sorts `items` on one thread, in ascending order of the bits [first_bit, first_bit + bit_count).
/// `scratch` has the same size. @return the array with the result: `items` or `scratch`
uint64_t* stp_sort_u64(uint64_t* items, uint64_t* scratch, size_t count, unsigned first_bit,
                       unsigned bit_count);

/// Sorts on all threads. Same result as stp_sort_u64, for any number of threads.
/// @return `items` or `scratch`; NULL if out of memory (not logged)
uint64_t* stp_parallel_sort_u64(stp_context* context, uint64_t* items, uint64_t* scratch,
                                size_t count, unsigned first_bit, unsigned bit_count);
