// SPDX-License-Identifier: MIT
// Eight floats at a time with AVX2. Same names and bits as vector_portable.h.
#pragma once

#include <immintrin.h>
#include <stdint.h>

typedef __m256 eight;

static inline eight eight_load(const float* from)
{
    return _mm256_load_ps(from);
}

static inline void eight_store(float* to, eight a)
{
    _mm256_store_ps(to, a);
}

static inline eight eight_set(float value)
{
    return _mm256_set1_ps(value);
}

static inline eight eight_add(eight a, eight b)
{
    return _mm256_add_ps(a, b);
}

static inline eight eight_sub(eight a, eight b)
{
    return _mm256_sub_ps(a, b);
}

static inline eight eight_mul(eight a, eight b)
{
    return _mm256_mul_ps(a, b);
}

static inline eight eight_min(eight a, eight b)
{
    return _mm256_min_ps(a, b);
}

static inline eight eight_max(eight a, eight b)
{
    return _mm256_max_ps(a, b);
}

static inline eight eight_root(eight a)
{
    return _mm256_sqrt_ps(a);
}

static inline uint32_t eight_less(eight a, eight b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

static inline uint32_t eight_equal(eight a, eight b)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_cmp_ps(a, b, _CMP_EQ_OQ));
}

static inline eight eight_blend(eight a, eight b, uint32_t mask)
{
    __m256i bits = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
    __m256i chosen = _mm256_and_si256(_mm256_set1_epi32((int)mask), bits);
    return _mm256_blendv_ps(a, b, _mm256_castsi256_ps(_mm256_cmpeq_epi32(chosen, bits)));
}

static inline float eight_highest(eight a)
{
    __m128 r = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    r = _mm_max_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_max_ss(r, _mm_shuffle_ps(r, r, 1)));
}

static inline float eight_lowest(eight a)
{
    __m128 r = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    r = _mm_min_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_min_ss(r, _mm_shuffle_ps(r, r, 1)));
}

#ifndef STP_WIDE_16
enum { WIDE = 8 };
typedef eight wide;
#define wide_load eight_load
#define wide_store eight_store
#define wide_set eight_set
#define wide_add eight_add
#define wide_sub eight_sub
#define wide_mul eight_mul
#define wide_min eight_min
#define wide_max eight_max
#define wide_root eight_root
#define wide_less eight_less
#define wide_equal eight_equal
#define wide_blend eight_blend
#define wide_highest eight_highest
#define wide_lowest eight_lowest
#endif
