// SPDX-License-Identifier: MIT
// Vectors of sixteen numbers.
#if defined(__x86_64__)

#include "draw/cpu/shade.h"

#include <immintrin.h>

#pragma GCC diagnostic ignored "-Wsign-conversion" // gcc's gather is a macro without optimisation

#define LANES 16

typedef int32_t lanes_int __attribute__((vector_size(64)));
typedef float lanes_float __attribute__((vector_size(64)));

static inline lanes_int lanes_index(void)
{
    return (lanes_int){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
}

static inline lanes_float lanes_gather(const float* base, lanes_int i)
{
    return (lanes_float)_mm512_i32gather_ps((__m512i)i, base, 4);
}

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int)_mm512_i32gather_epi32((__m512i)i, base, 1) & 255;
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    __mmask16 bits = _mm512_movepi32_mask((__m512i)mask);
    return (lanes_float)_mm512_mask_blend_ps(bits, (__m512)b, (__m512)a);
}

static inline lanes_float lanes_absolute(lanes_float a)
{
    return (lanes_float)((lanes_int)a & INT32_MAX);
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float)_mm512_sqrt_ps((__m512)a);
}

static inline bool lanes_none(lanes_int mask)
{
    return _mm512_movepi32_mask((__m512i)mask) == 0;
}

#include "draw/cpu/shade_lanes.h"

const cpu_shade_kernels cpu_shade_kernels_avx512 = {merge_chunk, light_chunk};

#else

typedef int not_for_this_processor;

#endif
