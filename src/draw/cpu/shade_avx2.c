// SPDX-License-Identifier: MIT
// Vectors of eight numbers.
#if defined(__x86_64__)

#include "draw/cpu/shade.h"

#include <immintrin.h>

#define LANES 8

typedef int32_t lanes_int __attribute__((vector_size(32)));
typedef float lanes_float __attribute__((vector_size(32)));

static inline lanes_int lanes_index(void)
{
    return (lanes_int){0, 1, 2, 3, 4, 5, 6, 7};
}

static inline lanes_float lanes_gather(const float* base, lanes_int i)
{
    return (lanes_float)_mm256_i32gather_ps(base, (__m256i)i, 4);
}

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int)_mm256_i32gather_epi32((const int*)(const void*)base, (__m256i)i, 1) & 255;
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)mask);
}

static inline lanes_float lanes_absolute(lanes_float a)
{
    return (lanes_float)((lanes_int)a & INT32_MAX);
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float)_mm256_sqrt_ps((__m256)a);
}

static inline bool lanes_none(lanes_int mask)
{
    return _mm256_testz_si256((__m256i)mask, (__m256i)mask) != 0;
}

#include "draw/cpu/shade_lanes.h"

const cpu_shade_kernels cpu_shade_kernels_avx2 = {merge_chunk, light_chunk};

#else

typedef int not_for_this_processor;

#endif
