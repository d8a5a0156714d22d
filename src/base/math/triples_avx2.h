// SPDX-License-Identifier: MIT
// Loads eight vectors of three floats at a time. Only for files compiled for AVX2.
#pragma once

#include <immintrin.h>

/// Loads eight consecutive vectors as columns x, y, z.
static inline void stp_load_triples(const float* from, __m256* x, __m256* y, __m256* z)
{
    __m256 a = _mm256_set_m128(_mm_loadu_ps(from + 12), _mm_loadu_ps(from));
    __m256 b = _mm256_set_m128(_mm_loadu_ps(from + 16), _mm_loadu_ps(from + 4));
    __m256 c = _mm256_set_m128(_mm_loadu_ps(from + 20), _mm_loadu_ps(from + 8));
    __m256 xy = _mm256_shuffle_ps(b, c, _MM_SHUFFLE(2, 1, 3, 2));
    __m256 yz = _mm256_shuffle_ps(a, b, _MM_SHUFFLE(1, 0, 2, 1));
    *x = _mm256_shuffle_ps(a, xy, _MM_SHUFFLE(2, 0, 3, 0));
    *y = _mm256_shuffle_ps(yz, xy, _MM_SHUFFLE(3, 1, 2, 0));
    *z = _mm256_shuffle_ps(yz, c, _MM_SHUFFLE(3, 0, 3, 1));
}
