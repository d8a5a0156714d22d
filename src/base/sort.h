// SPDX-License-Identifier: MIT
// Radix sort of 64-bit items by some of their bits. Stable; linear time; one thread.
#pragma once

#include <stddef.h>
#include <stdint.h>

/// Sorts `items` in ascending order of the bits [first_bit, first_bit + bit_count). `scratch` has
/// the same size. @return the array with the result: `items` or `scratch`
uint64_t* stp_sort_u64(uint64_t* items, uint64_t* scratch, size_t count, unsigned first_bit,
                       unsigned bit_count);
