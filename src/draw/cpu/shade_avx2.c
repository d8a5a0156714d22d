// SPDX-License-Identifier: MIT
// Vectors of eight numbers.
#include "draw/cpu/shade.h"

#include <immintrin.h>

#define LANES 8

typedef int32_t lanes_int __attribute__((vector_size(32)));
typedef float lanes_float __attribute__((vector_size(32)));

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int)_mm256_i32gather_epi32((const int*)(const void*)base, (__m256i)i, 1) & 255;
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)_mm256_blendv_ps((__m256)b, (__m256)a, (__m256)mask);
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float)_mm256_sqrt_ps((__m256)a);
}

/// Bit i: the sign of number i.
static inline uint32_t lanes_mask(lanes_int a)
{
    return (uint32_t)_mm256_movemask_ps((__m256)a);
}

/// Upper halves of pixels.
static inline lanes_int lanes_upper(const uint64_t* from)
{
    __m256 low = _mm256_loadu_ps((const float*)(const void*)from);
    __m256 high = _mm256_loadu_ps((const float*)(const void*)(from + 4));
    __m256i mixed = (__m256i)_mm256_shuffle_ps(low, high, 0xDD); // 0 1 4 5 2 3 6 7
    return (lanes_int)_mm256_permute4x64_epi64(mixed, 0xD8);
}

/// Transposed surfaces: field k of all.
static inline void lanes_turn(const stp_cpu_shade_surface* surfaces, const uint32_t* index,
                              lanes_float field[16])
{
    for (int k = 0; k < 16; k += 4) {
        __m256 row[4];
        for (int i = 0; i < 4; ++i) {
            __m128 low = _mm_loadu_ps((const float*)&surfaces[index[i]] + k);
            __m128 high = _mm_loadu_ps((const float*)&surfaces[index[i + 4]] + k);
            row[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(low), high, 1);
        }
        __m256 a = _mm256_unpacklo_ps(row[0], row[1]), b = _mm256_unpackhi_ps(row[0], row[1]);
        __m256 c = _mm256_unpacklo_ps(row[2], row[3]), d = _mm256_unpackhi_ps(row[2], row[3]);
        field[k] = (lanes_float)_mm256_shuffle_ps(a, c, 0x44);
        field[k + 1] = (lanes_float)_mm256_shuffle_ps(a, c, 0xEE);
        field[k + 2] = (lanes_float)_mm256_shuffle_ps(b, d, 0x44);
        field[k + 3] = (lanes_float)_mm256_shuffle_ps(b, d, 0xEE);
    }
}

#include "draw/cpu/shade_lanes.h"

const stp_cpu_shade_kernels stp_cpu_shade_kernels_vector = {merge_row, light_all, spread_row,
                                                            find_depths};
