// SPDX-License-Identifier: MIT
// Writes four pixels of the visibility buffer at a time (raster/target.h), with AVX2 or NEON. There
// is no masked store: pixels beside a primitive are read and written back, so they must not be
// another thread's.
#pragma once

#include "base/math/f32x8.h"

#if defined(__AVX2__)

/// An id in all pixels.
typedef __m256i stp_pixel_ids;

static inline stp_pixel_ids stp_pixel_ids_of(uint32_t id)
{
    return _mm256_set1_epi64x((long long)id);
}

static inline __m256i stp_pixels_of(i32x4 depths, stp_pixel_ids ids)
{
    return _mm256_or_si256(_mm256_slli_epi64(_mm256_cvtepu32_epi64(depths), 32), ids);
}

/// Where `inside` (-1) is set. Depths begin with a set bit, so the signed comparison orders pixels
/// like an unsigned one, including empty ones.
static inline void stp_pixels_write_some(uint64_t* pixels, i32x4 depths, i32x4 inside,
                                         stp_pixel_ids ids)
{
    __m256i pixel = stp_pixels_of(depths, ids);
    __m256i old = _mm256_loadu_si256((const __m256i_u*)(const void*)pixels);
    __m256i nearer =
        _mm256_and_si256(_mm256_cmpgt_epi64(old, pixel), _mm256_cvtepi32_epi64(inside));
    _mm256_storeu_si256((__m256i_u*)(void*)pixels, _mm256_blendv_epi8(old, pixel, nearer));
}

/// All four, with any depths.
static inline void stp_pixels_write_four(uint64_t* pixels, i32x4 depths, stp_pixel_ids ids)
{
    const __m256i top = _mm256_set1_epi64x((long long)(UINT64_C(1) << 63)); // for unsigned order
    __m256i pixel = stp_pixels_of(depths, ids);
    __m256i old = _mm256_loadu_si256((const __m256i_u*)(const void*)pixels);
    __m256i nearer = _mm256_cmpgt_epi64(_mm256_xor_si256(old, top), _mm256_xor_si256(pixel, top));
    _mm256_storeu_si256((__m256i_u*)(void*)pixels, _mm256_blendv_epi8(old, pixel, nearer));
}

#else

/// An id in all pixels.
typedef uint64x2_t stp_pixel_ids;

static inline stp_pixel_ids stp_pixel_ids_of(uint32_t id)
{
    return vdupq_n_u64(id);
}

/// Two pixels, where `inside` (-1) is set.
static inline void stp_pixels_write_two(uint64_t* pixels, uint32x2_t depths, int32x2_t inside,
                                        stp_pixel_ids ids)
{
    uint64x2_t pixel = vorrq_u64(vshll_n_u32(depths, 32), ids), old = vld1q_u64(pixels);
    uint64x2_t there = vreinterpretq_u64_s64(vmovl_s32(inside));
    vst1q_u64(pixels, vbslq_u64(vandq_u64(vcltq_u64(pixel, old), there), pixel, old));
}

/// Where `inside` (-1) is set.
static inline void stp_pixels_write_some(uint64_t* pixels, i32x4 depths, i32x4 inside,
                                         stp_pixel_ids ids)
{
    uint32x4_t d = vreinterpretq_u32_s32(depths);
    stp_pixels_write_two(pixels, vget_low_u32(d), vget_low_s32(inside), ids);
    stp_pixels_write_two(pixels + 2, vget_high_u32(d), vget_high_s32(inside), ids);
}

/// All four.
static inline void stp_pixels_write_four(uint64_t* pixels, i32x4 depths, stp_pixel_ids ids)
{
    stp_pixels_write_some(pixels, depths, vdupq_n_s32(-1), ids);
}

#endif
