// SPDX-License-Identifier: MIT
// Triangle kernels with vectors of sixteen numbers.
#include "raster/triangles_internal.h"

#include <immintrin.h>

#pragma GCC diagnostic ignored "-Wsign-conversion" // without optimisation, gcc's gather is a macro

#define LANES 16
#define LANES_ALL 0xFFFFu

typedef int32_t lanes_int __attribute__((vector_size(64)));
typedef uint32_t lanes_uint __attribute__((vector_size(64)));
typedef float lanes_float __attribute__((vector_size(64)));
// half as many doubles
typedef double lanes_real __attribute__((vector_size(64)));
typedef int64_t lanes_long __attribute__((vector_size(64)));

static inline lanes_int lanes_index(void)
{
    return (lanes_int){0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
}

/// Deinterleaves three vectors: a b c a b c ... Number w = 3 i + k goes to lane i of vector k.
static inline void lanes_load3(const void* source, lanes_int out[3])
{
    const int32_t* words = source;
    __m512i a = _mm512_loadu_si512(words), b = _mm512_loadu_si512(words + 16);
    __m512i c = _mm512_loadu_si512(words + 32);
    lanes_int wanted = lanes_index() * 3;
    for (int k = 0; k < 3; ++k, wanted += 1) {
        __m512i from_c = (__m512i)(wanted - 16);
        __mmask16 in_c = _mm512_cmpgt_epi32_mask((__m512i)wanted, _mm512_set1_epi32(31));
        __m512i from_ab = _mm512_permutex2var_epi32(a, (__m512i)wanted, b);
        out[k] = (lanes_int)_mm512_mask_permutexvar_epi32(from_ab, in_c, from_c, c);
    }
}

static inline lanes_int lanes_gather(const int32_t* base, lanes_int index)
{
    return (lanes_int)_mm512_i32gather_epi32((__m512i)index, base, 4);
}

static inline lanes_int lanes_select(lanes_int mask, lanes_int a, lanes_int b)
{
    return (lanes_int)_mm512_mask_mov_epi32((__m512i)b, _mm512_movepi32_mask((__m512i)mask),
                                            (__m512i)a);
}

static inline lanes_float lanes_select_float(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)lanes_select(mask, (lanes_int)a, (lanes_int)b);
}

static inline lanes_int lanes_min(lanes_int a, lanes_int b)
{
    return (lanes_int)_mm512_min_epi32((__m512i)a, (__m512i)b);
}

static inline lanes_int lanes_max(lanes_int a, lanes_int b)
{
    return (lanes_int)_mm512_max_epi32((__m512i)a, (__m512i)b);
}

/// a where it is less than b, else b.
static inline lanes_float lanes_min_float(lanes_float a, lanes_float b)
{
    return (lanes_float)_mm512_min_ps((__m512)a, (__m512)b);
}

static inline lanes_float lanes_max_float(lanes_float a, lanes_float b)
{
    return (lanes_float)_mm512_max_ps((__m512)a, (__m512)b);
}

static inline uint32_t lanes_sign_bits(lanes_int a)
{
    return (uint32_t)_mm512_movepi32_mask((__m512i)a);
}

static inline uint32_t lanes_long_bits(lanes_long a)
{
    return (uint32_t)_mm512_movepi64_mask((__m512i)a);
}

/// Rounds doubles to float: first `low`, then `high`.
static inline lanes_float lanes_narrow(lanes_real low, lanes_real high)
{
    __m512 both = _mm512_castps256_ps512(_mm512_cvtpd_ps((__m512d)low));
    return (lanes_float)_mm512_insertf32x8(both, _mm512_cvtpd_ps((__m512d)high), 1);
}

static inline lanes_int lanes_round(lanes_float a)
{
    return (lanes_int)_mm512_cvtps_epi32((__m512)a);
}

static inline void write_half(uint64_t* pixels, __mmask8 bits, __m256i far, __m512i id)
{
    __m512i pixel = _mm512_or_si512(_mm512_slli_epi64(_mm512_cvtepu32_epi64(far), 32), id);
    __m512i old = _mm512_maskz_loadu_epi64(bits, pixels);
    _mm512_mask_storeu_epi64(pixels, _mm512_mask_cmplt_epu64_mask(bits, pixel, old), pixel);
}

static inline void lanes_write(uint64_t* pixels, uint32_t bits, lanes_int nearness, uint32_t id)
{
    __m512i far = (__m512i)~nearness, ids = _mm512_set1_epi64((long long)id);
    write_half(pixels, (__mmask8)bits, _mm512_castsi512_si256(far), ids);
    if (bits >> 8 != 0) {
        write_half(pixels + 8, (__mmask8)(bits >> 8), _mm512_extracti64x4_epi64(far, 1), ids);
    }
}

/// Writes pixels of two rows, eight in each.
static inline void lanes_write_narrow(uint64_t* pixels, size_t stride, uint32_t bits,
                                      lanes_int nearness, uint32_t id)
{
    __m512i far = (__m512i)~nearness, ids = _mm512_set1_epi64((long long)id);
    if ((bits & 0xFF) != 0) {
        write_half(pixels, (__mmask8)bits, _mm512_castsi512_si256(far), ids);
    }
    if (bits >> 8 != 0) {
        write_half(pixels + stride, (__mmask8)(bits >> 8), _mm512_extracti64x4_epi64(far, 1), ids);
    }
}

#include "raster/triangles_lanes.h"

const stp_triangle_kernels stp_triangle_kernels_wide = {
    .find_range = find_range,
    .transform = transform_vertices,
    .draw_chunk = draw_chunk,
    .draw_one = draw_one,
};
