// SPDX-License-Identifier: MIT
// stp_octahedral_encode, eight at a time: same operations in the same order, so same codes.
#include "base/splats/octahedral.h"

#include <assert.h>

#if defined(__x86_64__)

#include "base/math/triples_avx2.h"

#include <float.h>

typedef struct vector3 {
    __m256 x, y, z;
} vector3;

static inline __m256 magnitude(__m256 a)
{
    return _mm256_andnot_ps(_mm256_set1_ps(-0.0f), a);
}

static inline __m256 is_negative(__m256 a)
{
    return _mm256_cmp_ps(a, _mm256_setzero_ps(), _CMP_LT_OQ);
}

static inline __m256 negate(__m256 a)
{
    return _mm256_xor_ps(a, _mm256_set1_ps(-0.0f));
}

static inline __m256 sum_of_products(vector3 a, vector3 b)
{
    __m256 sum = _mm256_add_ps(_mm256_mul_ps(a.x, b.x), _mm256_mul_ps(a.y, b.y));
    return _mm256_add_ps(sum, _mm256_mul_ps(a.z, b.z));
}

// stp_normalize of four vectors; vectors without a direction become zero here too.
static inline void normalize_four(__m128 x, __m128 y, __m128 z, __m128 out[3])
{
    __m256d a = _mm256_cvtps_pd(x), b = _mm256_cvtps_pd(y), c = _mm256_cvtps_pd(z);
    __m256d sum = _mm256_add_pd(_mm256_mul_pd(a, a), _mm256_mul_pd(b, b));
    __m256d length = _mm256_sqrt_pd(_mm256_add_pd(sum, _mm256_mul_pd(c, c)));
    __m256d usable = _mm256_and_pd(_mm256_cmp_pd(length, _mm256_setzero_pd(), _CMP_GT_OQ),
                                   _mm256_cmp_pd(length, _mm256_set1_pd(DBL_MAX), _CMP_LE_OQ));
    out[0] = _mm256_cvtpd_ps(_mm256_and_pd(_mm256_div_pd(a, length), usable));
    out[1] = _mm256_cvtpd_ps(_mm256_and_pd(_mm256_div_pd(b, length), usable));
    out[2] = _mm256_cvtpd_ps(_mm256_and_pd(_mm256_div_pd(c, length), usable));
}

static inline vector3 normalize(vector3 n)
{
    __m128 low[3], high[3];
    normalize_four(_mm256_castps256_ps128(n.x), _mm256_castps256_ps128(n.y),
                   _mm256_castps256_ps128(n.z), low);
    normalize_four(_mm256_extractf128_ps(n.x, 1), _mm256_extractf128_ps(n.y, 1),
                   _mm256_extractf128_ps(n.z, 1), high);
    return (vector3){_mm256_set_m128(high[0], low[0]), _mm256_set_m128(high[1], low[1]),
                     _mm256_set_m128(high[2], low[2])};
}

// Places of unit vectors on the unfolded square, in codes, rounded down.
static inline void unfold(vector3 n, __m256i* base_u, __m256i* base_v)
{
    __m256 sum = _mm256_add_ps(_mm256_add_ps(magnitude(n.x), magnitude(n.y)), magnitude(n.z));
    __m256 u = _mm256_div_ps(n.x, sum), v = _mm256_div_ps(n.y, sum), one = _mm256_set1_ps(1.0f);
    __m256 across = _mm256_sub_ps(one, magnitude(v)), along = _mm256_sub_ps(one, magnitude(u));
    across = _mm256_blendv_ps(across, negate(across), is_negative(u));
    along = _mm256_blendv_ps(along, negate(along), is_negative(v));
    __m256 below = is_negative(n.z);
    u = _mm256_blendv_ps(u, across, below);
    v = _mm256_blendv_ps(v, along, below);
    __m256 scale = _mm256_set1_ps(127.0f), half = _mm256_set1_ps(128.0f);
    __m256i whole = _mm256_set1_epi32(128);
    u = _mm256_add_ps(_mm256_mul_ps(u, scale), half);
    v = _mm256_add_ps(_mm256_mul_ps(v, scale), half);
    *base_u = _mm256_sub_epi32(_mm256_cvttps_epi32(u), whole);
    *base_v = _mm256_sub_epi32(_mm256_cvttps_epi32(v), whole);
}

static inline __m256i clamp_codes(__m256i code)
{
    return _mm256_min_epi32(_mm256_max_epi32(code, _mm256_set1_epi32(-127)),
                            _mm256_set1_epi32(127));
}

// Dot products of the decoded codes with the vectors.
static inline __m256 measure_agreement(vector3 n, __m256i code_u, __m256i code_v)
{
    __m256 scale = _mm256_set1_ps(127.0f);
    __m256 u = _mm256_div_ps(_mm256_cvtepi32_ps(code_u), scale);
    __m256 v = _mm256_div_ps(_mm256_cvtepi32_ps(code_v), scale);
    __m256 z = _mm256_sub_ps(_mm256_sub_ps(_mm256_set1_ps(1.0f), magnitude(u)), magnitude(v));
    __m256 fold = _mm256_and_ps(negate(z), is_negative(z));
    u = _mm256_add_ps(u, _mm256_blendv_ps(negate(fold), fold, is_negative(u)));
    v = _mm256_add_ps(v, _mm256_blendv_ps(negate(fold), fold, is_negative(v)));
    vector3 place = {u, v, z};
    __m256 length = _mm256_sqrt_ps(sum_of_products(place, place));
    vector3 decoded = {_mm256_div_ps(u, length), _mm256_div_ps(v, length),
                       _mm256_div_ps(z, length)};
    return sum_of_products(n, decoded);
}

static void encode_eight(const float* normals, int8_t* out)
{
    vector3 n;
    stp_load_triples(normals, &n.x, &n.y, &n.z);
    n = normalize(n);
    __m256i base_u, base_v;
    unfold(n, &base_u, &base_v);
    __m256 best = _mm256_set1_ps(-2.0f); // NaN is never better: zero keeps code 0
    __m256i best_u = _mm256_setzero_si256(), best_v = best_u;
    for (int i = 0; i < 4; ++i) {
        __m256i u = clamp_codes(_mm256_add_epi32(base_u, _mm256_set1_epi32(i & 1)));
        __m256i v = clamp_codes(_mm256_add_epi32(base_v, _mm256_set1_epi32(i >> 1)));
        __m256 agreement = measure_agreement(n, u, v);
        __m256 better = _mm256_cmp_ps(agreement, best, _CMP_GT_OQ);
        best = _mm256_blendv_ps(best, agreement, better);
        best_u = _mm256_blendv_epi8(best_u, u, _mm256_castps_si256(better));
        best_v = _mm256_blendv_epi8(best_v, v, _mm256_castps_si256(better));
    }
    __m256 sum = _mm256_add_ps(_mm256_add_ps(magnitude(n.x), magnitude(n.y)), magnitude(n.z));
    __m256i usable = _mm256_castps_si256(_mm256_cmp_ps(sum, _mm256_setzero_ps(), _CMP_GT_OQ));
    __m256i byte = _mm256_and_si256(usable, _mm256_set1_epi32(0xff));
    __m256i pairs = _mm256_or_si256(_mm256_and_si256(best_u, byte),
                                    _mm256_slli_epi32(_mm256_and_si256(best_v, byte), 8));
    __m128i packed =
        _mm_packus_epi32(_mm256_castsi256_si128(pairs), _mm256_extracti128_si256(pairs, 1));
    _mm_storeu_si128((__m128i*)(void*)out, packed);
}

size_t stp_octahedral_encode_avx2(const float* normals, size_t count, int8_t* out)
{
    size_t done = 0;
    for (; count - done >= 8; done += 8) {
        encode_eight(normals + 3 * done, out + 2 * done);
    }
    assert(count - done < 8 && done % 8 == 0);
    return done;
}

#endif
