// SPDX-License-Identifier: MIT
// Triangle kernels with vectors of eight numbers.
#include "raster/pixels_write.h"
#include "raster/triangles_internal.h"

#define LANES 8
#define LANES_ALL 0xFFu

typedef int32_t lanes_int __attribute__((vector_size(32)));
typedef uint32_t lanes_uint __attribute__((vector_size(32)));
typedef float lanes_float __attribute__((vector_size(32)));
// half as many doubles
typedef double lanes_real __attribute__((vector_size(32)));
typedef int64_t lanes_long __attribute__((vector_size(32)));

static inline lanes_int lanes_index(void)
{
    return (lanes_int){0, 1, 2, 3, 4, 5, 6, 7};
}

/// Deinterleaves three vectors: a b c a b c ... Number w = 3 i + k goes to lane i of vector k, from
/// lane w mod 8 of its source.
static inline void lanes_load3(const void* source, lanes_int out[3])
{
    const __m256i* words = source;
    __m256i a = _mm256_loadu_si256(words), b = _mm256_loadu_si256(words + 1);
    __m256i c = _mm256_loadu_si256(words + 2);
    __m256i from0 = _mm256_setr_epi32(0, 3, 6, 1, 4, 7, 2, 5);
    __m256i from1 = _mm256_setr_epi32(1, 4, 7, 2, 5, 0, 3, 6);
    __m256i from2 = _mm256_setr_epi32(2, 5, 0, 3, 6, 1, 4, 7);
    __m256i m0 = _mm256_blend_epi32(_mm256_blend_epi32(a, b, 0x92), c, 0x24);
    __m256i m1 = _mm256_blend_epi32(_mm256_blend_epi32(a, b, 0x24), c, 0x49);
    __m256i m2 = _mm256_blend_epi32(_mm256_blend_epi32(a, b, 0x49), c, 0x92);
    out[0] = (lanes_int)_mm256_permutevar8x32_epi32(m0, from0);
    out[1] = (lanes_int)_mm256_permutevar8x32_epi32(m1, from1);
    out[2] = (lanes_int)_mm256_permutevar8x32_epi32(m2, from2);
}

static inline lanes_int lanes_gather(const int32_t* base, lanes_int index)
{
    return (lanes_int)_mm256_i32gather_epi32(base, (__m256i)index, 4);
}

static inline lanes_int lanes_select(lanes_int mask, lanes_int a, lanes_int b)
{
    return (lanes_int)_mm256_blendv_epi8((__m256i)b, (__m256i)a, (__m256i)mask);
}

static inline lanes_float lanes_select_float(lanes_int mask, lanes_float a, lanes_float b)
{
    return (lanes_float)lanes_select(mask, (lanes_int)a, (lanes_int)b);
}

static inline lanes_int lanes_min(lanes_int a, lanes_int b)
{
    return (lanes_int)_mm256_min_epi32((__m256i)a, (__m256i)b);
}

static inline lanes_int lanes_max(lanes_int a, lanes_int b)
{
    return (lanes_int)_mm256_max_epi32((__m256i)a, (__m256i)b);
}

/// a where it is less than b, else b.
static inline lanes_float lanes_min_float(lanes_float a, lanes_float b)
{
    return (lanes_float)_mm256_min_ps((__m256)a, (__m256)b);
}

static inline lanes_float lanes_max_float(lanes_float a, lanes_float b)
{
    return (lanes_float)_mm256_max_ps((__m256)a, (__m256)b);
}

static inline uint32_t lanes_sign_bits(lanes_int a)
{
    return (uint32_t)_mm256_movemask_ps((__m256)a);
}

static inline uint32_t lanes_long_bits(lanes_long a)
{
    return (uint32_t)_mm256_movemask_pd((__m256d)a);
}

/// Rounds doubles to float: first `low`, then `high`.
static inline lanes_float lanes_narrow(lanes_real low, lanes_real high)
{
    return (lanes_float)_mm256_set_m128(_mm256_cvtpd_ps((__m256d)high),
                                        _mm256_cvtpd_ps((__m256d)low));
}

static inline lanes_int lanes_round(lanes_float a)
{
    return (lanes_int)_mm256_cvtps_epi32((__m256)a);
}

#include "raster/triangles_narrow.h"

static inline void lanes_write(uint64_t* pixels, uint32_t bits, lanes_int nearness, uint32_t id)
{
    const __m256i far = (__m256i)~nearness;
    const stp_pixel_ids ids = stp_pixel_ids_of(id);
    if ((bits & 15) == 15) {
        stp_pixels_write_four(pixels, i32x8_low(far), ids);
        bits &= ~15u;
    }
    if (bits >> 4 == 15) {
        stp_pixels_write_four(pixels + 4, i32x8_high(far), ids);
        bits &= 15;
    }
    lanes_write_each(pixels, bits, nearness, id);
}

#include "raster/triangles_lanes.h"

const stp_triangle_kernels stp_triangle_kernels_vector = {
    .find_range = find_range,
    .transform = transform_vertices,
    .draw_chunk = draw_chunk,
    .draw_one = draw_one,
};
