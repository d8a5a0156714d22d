// SPDX-License-Identifier: MIT
// Loads eight splats, by columns, with AVX2 or NEON.
#pragma once

#include "base/math/f32x8.h"

#if defined(__AVX2__)

/// 24 grid coordinates, deinterleaved into eight of each.
static inline void load_eight_positions(const uint16_t* positions, float* x, float* y, float* z)
{
    enum { Z = -1 };
    const __m128i* at = (const __m128i*)(const void*)positions;
    __m128i a = _mm_loadu_si128(at), b = _mm_loadu_si128(at + 1), c = _mm_loadu_si128(at + 2);
    // a: x0 y0 z0 x1 y1 z1 x2 y2   b: z2 x3 y3 z3 x4 y4 z4 x5   c: y5 z5 x6 y6 z6 x7 y7 z7
    __m128i xs = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(0, 1, 6, 7, 12, 13, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, 2, 3, 8, 9, 14, 15, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 4, 5, 10, 11)));
    __m128i ys = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(2, 3, 8, 9, 14, 15, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, 4, 5, 10, 11, Z, Z, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 0, 1, 6, 7, 12, 13)));
    __m128i zs = _mm_or_si128(
        _mm_or_si128(
            _mm_shuffle_epi8(a, _mm_setr_epi8(4, 5, 10, 11, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, Z)),
            _mm_shuffle_epi8(b, _mm_setr_epi8(Z, Z, Z, Z, 0, 1, 6, 7, 12, 13, Z, Z, Z, Z, Z, Z))),
        _mm_shuffle_epi8(c, _mm_setr_epi8(Z, Z, Z, Z, Z, Z, Z, Z, Z, Z, 2, 3, 8, 9, 14, 15)));
    _mm256_storeu_ps(x, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(xs)));
    _mm256_storeu_ps(y, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(ys)));
    _mm256_storeu_ps(z, _mm256_cvtepi32_ps(_mm256_cvtepu16_epi32(zs)));
}

/// Eight pairs of bytes.
static inline void load_eight_normals(const int8_t* normals, float* nu, float* nv)
{
    __m256i pairs = _mm256_cvtepi16_epi32(_mm_loadu_si128((const __m128i*)(const void*)normals));
    __m256i u = _mm256_srai_epi32(_mm256_slli_epi32(pairs, 24), 24);
    __m256i v = _mm256_srai_epi32(pairs, 8);
    _mm256_storeu_ps(nu, _mm256_cvtepi32_ps(u));
    _mm256_storeu_ps(nv, _mm256_cvtepi32_ps(v));
}

#else

static inline void store_shorts(float* to, uint16x8_t a)
{
    vst1q_f32(to, vcvtq_f32_u32(vmovl_u16(vget_low_u16(a))));
    vst1q_f32(to + 4, vcvtq_f32_u32(vmovl_u16(vget_high_u16(a))));
}

/// 24 grid coordinates, deinterleaved into eight of each.
static inline void load_eight_positions(const uint16_t* positions, float* x, float* y, float* z)
{
    uint16x8x3_t columns = vld3q_u16(positions);
    store_shorts(x, columns.val[0]);
    store_shorts(y, columns.val[1]);
    store_shorts(z, columns.val[2]);
}

static inline void store_bytes(float* to, int8x8_t a)
{
    int16x8_t wide = vmovl_s8(a);
    vst1q_f32(to, vcvtq_f32_s32(vmovl_s16(vget_low_s16(wide))));
    vst1q_f32(to + 4, vcvtq_f32_s32(vmovl_s16(vget_high_s16(wide))));
}

/// Eight pairs of bytes.
static inline void load_eight_normals(const int8_t* normals, float* nu, float* nv)
{
    int8x8x2_t columns = vld2_s8(normals);
    store_bytes(nu, columns.val[0]);
    store_bytes(nv, columns.val[1]);
}

#endif
