// SPDX-License-Identifier: MIT
// The operations of f32x8.h with AVX2.
#pragma once

#include <immintrin.h>
#include <stddef.h>
#include <stdint.h>

typedef __m256 f32x8;
typedef __m256i i32x8;
typedef __m128i i32x4;

// Loads, stores and conversions. Addresses need no alignment.

static inline f32x8 f32x8_load(const float* from)
{
    return _mm256_loadu_ps(from);
}

static inline void f32x8_store(float* to, f32x8 a)
{
    _mm256_storeu_ps(to, a);
}

static inline f32x8 f32x8_set(float value)
{
    return _mm256_set1_ps(value);
}

static inline i32x8 i32x8_load(const int32_t* from)
{
    return _mm256_loadu_si256((const __m256i_u*)(const void*)from);
}

static inline void i32x8_store(int32_t* to, i32x8 a)
{
    _mm256_storeu_si256((__m256i_u*)(void*)to, a);
}

static inline i32x8 i32x8_set(int32_t value)
{
    return _mm256_set1_epi32(value);
}

static inline i32x4 i32x8_low(i32x8 a)
{
    return _mm256_castsi256_si128(a);
}

static inline i32x4 i32x8_high(i32x8 a)
{
    return _mm256_extracti128_si256(a, 1);
}

static inline i32x8 f32x8_as_int(f32x8 a)
{
    return _mm256_castps_si256(a);
}

static inline f32x8 i32x8_as_float(i32x8 a)
{
    return _mm256_castsi256_ps(a);
}

static inline f32x8 i32x8_to_float(i32x8 a)
{
    return _mm256_cvtepi32_ps(a);
}

/// Towards zero. Undefined beyond 32 bits.
static inline i32x8 f32x8_truncate(f32x8 a)
{
    return _mm256_cvttps_epi32(a);
}

/// Bit k: the sign of lane k.
static inline uint32_t i32x8_signs(i32x8 a)
{
    return (uint32_t)_mm256_movemask_ps(_mm256_castsi256_ps(a));
}

/// Floats at a distance of `stride`.
static inline f32x8 f32x8_load_apart(const float* p, size_t stride)
{
    return _mm256_setr_ps(p[0], p[stride], p[2 * stride], p[3 * stride], p[4 * stride],
                          p[5 * stride], p[6 * stride], p[7 * stride]);
}

/// Eight consecutive vectors of three floats, as columns.
static inline void f32x8_load_triples(const float* from, f32x8* x, f32x8* y, f32x8* z)
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

/// The reverse of f32x8_load_triples.
static inline void f32x8_store_triples(float* to, f32x8 x, f32x8 y, f32x8 z)
{
    // place i of vector k is number 8 k + i: axis (8 k + i) mod 3 of vector (8 k + i) / 3
    const __m256i from[3][3] = {
        {_mm256_setr_epi32(0, 0, 0, 1, 0, 0, 2, 0), _mm256_setr_epi32(0, 0, 0, 0, 1, 0, 0, 2),
         _mm256_setr_epi32(0, 0, 0, 0, 0, 1, 0, 0)},
        {_mm256_setr_epi32(0, 3, 0, 0, 4, 0, 0, 5), _mm256_setr_epi32(0, 0, 3, 0, 0, 4, 0, 0),
         _mm256_setr_epi32(2, 0, 0, 3, 0, 0, 4, 0)},
        {_mm256_setr_epi32(0, 0, 6, 0, 0, 7, 0, 0), _mm256_setr_epi32(5, 0, 0, 6, 0, 0, 7, 0),
         _mm256_setr_epi32(0, 5, 0, 0, 6, 0, 0, 7)},
    };
    __m256 a = _mm256_permutevar8x32_ps(x, from[0][0]), b = _mm256_permutevar8x32_ps(y, from[0][1]),
           c = _mm256_permutevar8x32_ps(z, from[0][2]);
    _mm256_storeu_ps(to, _mm256_blend_ps(_mm256_blend_ps(a, b, 0x92), c, 0x24));
    a = _mm256_permutevar8x32_ps(x, from[1][0]);
    b = _mm256_permutevar8x32_ps(y, from[1][1]);
    c = _mm256_permutevar8x32_ps(z, from[1][2]);
    _mm256_storeu_ps(to + 8, _mm256_blend_ps(_mm256_blend_ps(a, b, 0x24), c, 0x49));
    a = _mm256_permutevar8x32_ps(x, from[2][0]);
    b = _mm256_permutevar8x32_ps(y, from[2][1]);
    c = _mm256_permutevar8x32_ps(z, from[2][2]);
    _mm256_storeu_ps(to + 16, _mm256_blend_ps(_mm256_blend_ps(a, b, 0x49), c, 0x92));
}

/// Bytes of 16: each byte of `places` names one, 0..15.
static inline i32x8 i32x8_pick_bytes(const uint8_t* bytes, i32x8 places)
{
    __m128i half = _mm_loadu_si128((const __m128i_u*)(const void*)bytes);
    return _mm256_shuffle_epi8(_mm256_broadcastsi128_si256(half), places);
}

/// The bits of lane 0 in all lanes.
static inline i32x8 i32x8_repeat_first(i32x8 a)
{
    return _mm256_broadcastd_epi32(_mm256_castsi256_si128(a));
}

/// Words 2 index + `word` of an array of pairs; where the mask is not set, 0, and no memory is read.
static inline i32x8 i32x8_gather_pairs(const void* pairs, int word, i32x8 index, i32x8 mask)
{
    return _mm256_mask_i32gather_epi32(_mm256_setzero_si256(), (const int*)pairs + word, index,
                                       mask, 8);
}

/// The upper halves of eight 64-bit numbers.
static inline i32x8 i32x8_load_upper(const uint64_t* from)
{
    __m256 a = _mm256_loadu_ps((const float*)(const void*)from);
    __m256 b = _mm256_loadu_ps((const float*)(const void*)(from + 4));
    __m256i mixed = _mm256_castps_si256(_mm256_shuffle_ps(a, b, 0xDD)); // 0 1 4 5 2 3 6 7
    return _mm256_permute4x64_epi64(mixed, 0xD8);
}

// Floats.

static inline f32x8 f32x8_add(f32x8 a, f32x8 b)
{
    return _mm256_add_ps(a, b);
}

static inline f32x8 f32x8_sub(f32x8 a, f32x8 b)
{
    return _mm256_sub_ps(a, b);
}

static inline f32x8 f32x8_mul(f32x8 a, f32x8 b)
{
    return _mm256_mul_ps(a, b);
}

static inline f32x8 f32x8_div(f32x8 a, f32x8 b)
{
    return _mm256_div_ps(a, b);
}

/// a where it is less than b, else b.
static inline f32x8 f32x8_min(f32x8 a, f32x8 b)
{
    return _mm256_min_ps(a, b);
}

static inline f32x8 f32x8_max(f32x8 a, f32x8 b)
{
    return _mm256_max_ps(a, b);
}

static inline f32x8 f32x8_root(f32x8 a)
{
    return _mm256_sqrt_ps(a);
}

static inline f32x8 f32x8_floor(f32x8 a)
{
    return _mm256_floor_ps(a);
}

/// Masks. NaN is neither less than anything nor equal to it.
static inline i32x8 f32x8_less(f32x8 a, f32x8 b)
{
    return _mm256_castps_si256(_mm256_cmp_ps(a, b, _CMP_LT_OQ));
}

static inline i32x8 f32x8_less_equal(f32x8 a, f32x8 b)
{
    return _mm256_castps_si256(_mm256_cmp_ps(a, b, _CMP_LE_OQ));
}

static inline i32x8 f32x8_equal(f32x8 a, f32x8 b)
{
    return _mm256_castps_si256(_mm256_cmp_ps(a, b, _CMP_EQ_OQ));
}

/// a where the mask is set, else b.
static inline f32x8 f32x8_select(i32x8 mask, f32x8 a, f32x8 b)
{
    return _mm256_blendv_ps(b, a, _mm256_castsi256_ps(mask));
}

static inline float f32x8_lowest(f32x8 a)
{
    __m128 r = _mm_min_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    r = _mm_min_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_min_ss(r, _mm_shuffle_ps(r, r, 1)));
}

static inline float f32x8_highest(f32x8 a)
{
    __m128 r = _mm_max_ps(_mm256_castps256_ps128(a), _mm256_extractf128_ps(a, 1));
    r = _mm_max_ps(r, _mm_movehl_ps(r, r));
    return _mm_cvtss_f32(_mm_max_ss(r, _mm_shuffle_ps(r, r, 1)));
}

// Integers.

static inline i32x8 i32x8_add(i32x8 a, i32x8 b)
{
    return _mm256_add_epi32(a, b);
}

static inline i32x8 i32x8_sub(i32x8 a, i32x8 b)
{
    return _mm256_sub_epi32(a, b);
}

static inline i32x8 i32x8_mul(i32x8 a, i32x8 b)
{
    return _mm256_mullo_epi32(a, b);
}

static inline i32x8 i32x8_and(i32x8 a, i32x8 b)
{
    return _mm256_and_si256(a, b);
}

static inline i32x8 i32x8_or(i32x8 a, i32x8 b)
{
    return _mm256_or_si256(a, b);
}

static inline i32x8 i32x8_xor(i32x8 a, i32x8 b)
{
    return _mm256_xor_si256(a, b);
}

static inline i32x8 i32x8_min(i32x8 a, i32x8 b)
{
    return _mm256_min_epi32(a, b);
}

static inline i32x8 i32x8_max(i32x8 a, i32x8 b)
{
    return _mm256_max_epi32(a, b);
}

static inline i32x8 i32x8_min_unsigned(i32x8 a, i32x8 b)
{
    return _mm256_min_epu32(a, b);
}

static inline i32x8 i32x8_max_unsigned(i32x8 a, i32x8 b)
{
    return _mm256_max_epu32(a, b);
}

/// Shifts by 0..31; those to the right fill with zeros.
static inline i32x8 i32x8_left(i32x8 a, int bits)
{
    return _mm256_slli_epi32(a, bits);
}

static inline i32x8 i32x8_right(i32x8 a, int bits)
{
    return _mm256_srli_epi32(a, bits);
}

/// Fills with the sign.
static inline i32x8 i32x8_right_signed(i32x8 a, int bits)
{
    return _mm256_srai_epi32(a, bits);
}

/// Lanes by lanes of 0..31.
static inline i32x8 i32x8_left_by(i32x8 a, i32x8 bits)
{
    return _mm256_sllv_epi32(a, bits);
}

static inline i32x8 i32x8_right_by(i32x8 a, i32x8 bits)
{
    return _mm256_srlv_epi32(a, bits);
}

static inline i32x8 i32x8_equal(i32x8 a, i32x8 b)
{
    return _mm256_cmpeq_epi32(a, b);
}

static inline i32x8 i32x8_greater(i32x8 a, i32x8 b)
{
    return _mm256_cmpgt_epi32(a, b);
}

static inline i32x8 i32x8_select(i32x8 mask, i32x8 a, i32x8 b)
{
    return _mm256_blendv_epi8(b, a, mask);
}

/// How many bits of each lane are set.
static inline i32x8 i32x8_count_bits(i32x8 a)
{
    const __m256i table = _mm256_setr_epi8(0, 1, 1, 2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4, 0, 1, 1,
                                           2, 1, 2, 2, 3, 1, 2, 2, 3, 2, 3, 3, 4);
    const __m256i low = _mm256_set1_epi8(15);
    __m256i bytes =
        _mm256_add_epi8(_mm256_shuffle_epi8(table, _mm256_and_si256(a, low)),
                        _mm256_shuffle_epi8(table, _mm256_and_si256(_mm256_srli_epi32(a, 4), low)));
    __m256i pairs = _mm256_maddubs_epi16(bytes, _mm256_set1_epi8(1));
    return _mm256_madd_epi16(pairs, _mm256_set1_epi16(1));
}

static inline __m256i i32x4_repeat_bytes(__m128i bytes, __m128i first, __m128i last)
{
    const __m256i all = _mm256_set1_epi64x(-1),
                  spread = _mm256_setr_epi8(0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8, 0, 0, 0,
                                            0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8);
    __m256i below = _mm256_cvtepu32_epi64(_mm_slli_epi32(first, 3));
    __m256i above =
        _mm256_cvtepu32_epi64(_mm_sub_epi32(_mm_set1_epi32(56), _mm_slli_epi32(last, 3)));
    __m256i places = _mm256_and_si256(_mm256_sllv_epi64(all, below), _mm256_srlv_epi64(all, above));
    return _mm256_and_si256(places, _mm256_shuffle_epi8(_mm256_cvtepu32_epi64(bytes), spread));
}

/// 64 bits: the byte of each lane, repeated from place `first` to place `last` (0..7, 0 the lowest),
/// of all lanes together.
static inline uint64_t i32x8_join_bytes(i32x8 bytes, i32x8 first, i32x8 last)
{
    __m256i low = i32x4_repeat_bytes(i32x8_low(bytes), i32x8_low(first), i32x8_low(last));
    __m256i high = i32x4_repeat_bytes(i32x8_high(bytes), i32x8_high(first), i32x8_high(last));
    __m256i both = _mm256_or_si256(low, high);
    __m128i half = _mm_or_si128(i32x8_low(both), i32x8_high(both));
    return (uint64_t)_mm_cvtsi128_si64(half) | (uint64_t)_mm_extract_epi64(half, 1);
}
