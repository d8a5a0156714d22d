// SPDX-License-Identifier: MIT
// Vectors of four numbers in compiler notation, for the portable triangle kernels and NEON's.
#pragma once

#include <stdint.h>

#define LANES 4
#define LANES_ALL 0xFu

typedef int32_t lanes_int __attribute__((vector_size(16)));
typedef uint32_t lanes_uint __attribute__((vector_size(16)));
typedef float lanes_float __attribute__((vector_size(16)));
// half as many doubles
typedef double lanes_real __attribute__((vector_size(16)));
typedef int64_t lanes_long __attribute__((vector_size(16)));

static inline lanes_int lanes_index(void)
{
    return (lanes_int){0, 1, 2, 3};
}

static inline lanes_int lanes_gather(const int32_t* base, lanes_int i)
{
    return (lanes_int){base[i[0]], base[i[1]], base[i[2]], base[i[3]]};
}

static inline lanes_int lanes_select(lanes_int mask, lanes_int a, lanes_int b)
{
    return (mask & a) | (~mask & b);
}

static inline lanes_float lanes_select_float(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)lanes_select(mask, (lanes_int)a, (lanes_int)b);
}

/// a where it is less than b, else b.
static inline lanes_float lanes_min_float(lanes_float a, lanes_float b)
{
    return lanes_select_float(a < b, a, b);
}

static inline lanes_float lanes_max_float(lanes_float a, lanes_float b)
{
    return lanes_select_float(a > b, a, b);
}

static inline uint32_t lanes_long_bits(lanes_long a)
{
    return (uint32_t)((uint64_t)a[0] >> 63 | (uint64_t)a[1] >> 63 << 1);
}
