// SPDX-License-Identifier: MIT
// The radix sort of sort.h on all threads.
#pragma once

#include "base/context.h"
#include "base/sort.h"

/// As stp_sort_u64, with the same result for any number of threads.
/// @return `items` or `scratch`; NULL where memory runs out (not logged)
uint64_t* stp_parallel_sort_u64(stp_context* context, uint64_t* items, uint64_t* scratch,
                                size_t count, unsigned first_bit, unsigned bit_count);
