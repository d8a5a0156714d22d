// SPDX-License-Identifier: MIT
// The radix sort of sort.h on all threads.
#pragma once

#include "base/core/context.h"
#include "base/math/sort.h"

/// Same result as stp_sort_u64, for any number of threads.
/// @return `items` or `scratch`; NULL if out of memory (not logged)
uint64_t* stp_parallel_sort_u64(stp_context* context, uint64_t* items, uint64_t* scratch,
                                size_t count, unsigned first_bit, unsigned bit_count);
