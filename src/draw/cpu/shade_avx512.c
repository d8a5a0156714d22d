// SPDX-License-Identifier: MIT
// Vectors of sixteen numbers.
#include "draw/cpu/shade.h"

#include <immintrin.h>

#pragma GCC diagnostic ignored "-Wsign-conversion" // without optimisation, gcc's gather is a macro

#define LANES 16

typedef int32_t lanes_int __attribute__((vector_size(64)));
typedef float lanes_float __attribute__((vector_size(64)));

static inline lanes_int lanes_gather_byte(const uint8_t* base, lanes_int i)
{
    return (lanes_int)_mm512_i32gather_epi32((__m512i)i, base, 1) & 255;
}

static inline lanes_float lanes_select(lanes_int mask, lanes_float a, lanes_float b)
{
    __mmask16 bits = _mm512_movepi32_mask((__m512i)mask);
    return (lanes_float)_mm512_mask_blend_ps(bits, (__m512)b, (__m512)a);
}

static inline lanes_float lanes_root(lanes_float a)
{
    return (lanes_float)_mm512_sqrt_ps((__m512)a);
}

/// Bit i: the sign of number i.
static inline uint32_t lanes_mask(lanes_int a)
{
    return _mm512_movepi32_mask((__m512i)a);
}

/// Upper halves of pixels.
static inline lanes_int lanes_upper(const uint64_t* from)
{
    const __m512i odd =
        _mm512_setr_epi32(1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
    return (lanes_int)_mm512_permutex2var_epi32(_mm512_loadu_si512(from), odd,
                                                _mm512_loadu_si512(from + 8));
}

static inline __m512 load_four(const stp_cpu_shade_surface* surfaces, const uint32_t* index, int k)
{
    __m512 v = _mm512_castps128_ps512(_mm_loadu_ps((const float*)&surfaces[index[0]] + k));
    v = _mm512_mask_broadcast_f32x4(v, 0x00F0, _mm_loadu_ps((const float*)&surfaces[index[4]] + k));
    v = _mm512_mask_broadcast_f32x4(v, 0x0F00, _mm_loadu_ps((const float*)&surfaces[index[8]] + k));
    return _mm512_mask_broadcast_f32x4(v, 0xF000,
                                       _mm_loadu_ps((const float*)&surfaces[index[12]] + k));
}

/// Transposed surfaces: field k of all.
static inline void lanes_turn(const stp_cpu_shade_surface* surfaces, const uint32_t* index,
                              lanes_float field[16])
{
    for (int k = 0; k < 16; k += 4) {
        __m512 row[4];
        for (int i = 0; i < 4; ++i) {
            row[i] = load_four(surfaces, index + i, k);
        }
        __m512 a = _mm512_unpacklo_ps(row[0], row[1]), b = _mm512_unpackhi_ps(row[0], row[1]);
        __m512 c = _mm512_unpacklo_ps(row[2], row[3]), d = _mm512_unpackhi_ps(row[2], row[3]);
        field[k] = (lanes_float)_mm512_shuffle_ps(a, c, 0x44);
        field[k + 1] = (lanes_float)_mm512_shuffle_ps(a, c, 0xEE);
        field[k + 2] = (lanes_float)_mm512_shuffle_ps(b, d, 0x44);
        field[k + 3] = (lanes_float)_mm512_shuffle_ps(b, d, 0xEE);
    }
}

#include "draw/cpu/shade_lanes.h"

const stp_cpu_shade_kernels stp_cpu_shade_kernels_wide = {merge_row, light_all, spread_row,
                                                          find_depths};
