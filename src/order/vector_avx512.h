// SPDX-License-Identifier: MIT
// Sixteen floats at a time with AVX-512 for leaves. Branches have eight children (vector.h). Same
// names and bits as vector_portable.h.
#pragma once

#define STP_WIDE_16
#include "order/vector.h"

enum { WIDE = 16 };
typedef __m512 wide;

static inline wide wide_load(const float* from)
{
    return _mm512_load_ps(from);
}

static inline void wide_store(float* to, wide a)
{
    _mm512_store_ps(to, a);
}

static inline wide wide_set(float value)
{
    return _mm512_set1_ps(value);
}

static inline wide wide_add(wide a, wide b)
{
    return _mm512_add_ps(a, b);
}

static inline wide wide_sub(wide a, wide b)
{
    return _mm512_sub_ps(a, b);
}

static inline wide wide_mul(wide a, wide b)
{
    return _mm512_mul_ps(a, b);
}

static inline wide wide_min(wide a, wide b)
{
    return _mm512_min_ps(a, b);
}

static inline wide wide_max(wide a, wide b)
{
    return _mm512_max_ps(a, b);
}

static inline wide wide_root(wide a)
{
    return _mm512_sqrt_ps(a);
}

static inline uint32_t wide_less(wide a, wide b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_LT_OQ);
}

static inline uint32_t wide_equal(wide a, wide b)
{
    return _mm512_cmp_ps_mask(a, b, _CMP_EQ_OQ);
}

static inline wide wide_blend(wide a, wide b, uint32_t mask)
{
    return _mm512_mask_blend_ps((__mmask16)mask, a, b);
}

static inline float wide_highest(wide a)
{
    return eight_highest(_mm256_max_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1)));
}

static inline float wide_lowest(wide a)
{
    return eight_lowest(_mm256_min_ps(_mm512_castps512_ps256(a), _mm512_extractf32x8_ps(a, 1)));
}
