// SPDX-License-Identifier: MIT
// The operations of f32x8.h with NEON: two vectors of four.
#pragma once

#include <arm_neon.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef struct f32x8 {
    float32x4_t low, high;
} f32x8;
typedef struct i32x8 {
    int32x4_t low, high;
} i32x8;
typedef int32x4_t i32x4;

// Loads, stores and conversions. Addresses need no alignment.

static inline f32x8 f32x8_load(const float* from)
{
    return (f32x8){vld1q_f32(from), vld1q_f32(from + 4)};
}

static inline void f32x8_store(float* to, f32x8 a)
{
    vst1q_f32(to, a.low);
    vst1q_f32(to + 4, a.high);
}

static inline f32x8 f32x8_set(float value)
{
    return (f32x8){vdupq_n_f32(value), vdupq_n_f32(value)};
}

static inline i32x8 i32x8_load(const int32_t* from)
{
    return (i32x8){vld1q_s32(from), vld1q_s32(from + 4)};
}

static inline void i32x8_store(int32_t* to, i32x8 a)
{
    vst1q_s32(to, a.low);
    vst1q_s32(to + 4, a.high);
}

static inline i32x8 i32x8_set(int32_t value)
{
    return (i32x8){vdupq_n_s32(value), vdupq_n_s32(value)};
}

static inline i32x4 i32x8_low(i32x8 a)
{
    return a.low;
}

static inline i32x4 i32x8_high(i32x8 a)
{
    return a.high;
}

static inline i32x8 f32x8_as_int(f32x8 a)
{
    return (i32x8){vreinterpretq_s32_f32(a.low), vreinterpretq_s32_f32(a.high)};
}

static inline f32x8 i32x8_as_float(i32x8 a)
{
    return (f32x8){vreinterpretq_f32_s32(a.low), vreinterpretq_f32_s32(a.high)};
}

static inline f32x8 i32x8_to_float(i32x8 a)
{
    return (f32x8){vcvtq_f32_s32(a.low), vcvtq_f32_s32(a.high)};
}

/// Towards zero. Undefined beyond 32 bits.
static inline i32x8 f32x8_truncate(f32x8 a)
{
    return (i32x8){vcvtq_s32_f32(a.low), vcvtq_s32_f32(a.high)};
}

/// Bit k: the sign of lane k.
static inline uint32_t i32x8_signs(i32x8 a)
{
    static const int32_t places[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    uint32x4_t low = vshrq_n_u32(vreinterpretq_u32_s32(a.low), 31);
    uint32x4_t high = vshrq_n_u32(vreinterpretq_u32_s32(a.high), 31);
    low = vshlq_u32(low, vld1q_s32(places));
    high = vshlq_u32(high, vld1q_s32(places + 4));
    return vaddvq_u32(vorrq_u32(low, high));
}

/// Floats at a distance of `stride`.
static inline f32x8 f32x8_load_apart(const float* p, size_t stride)
{
    const float* q = p + 4 * stride;
    return (f32x8){(float32x4_t){p[0], p[stride], p[2 * stride], p[3 * stride]},
                   (float32x4_t){q[0], q[stride], q[2 * stride], q[3 * stride]}};
}

/// Eight consecutive vectors of three floats, as columns.
static inline void f32x8_load_triples(const float* from, f32x8* x, f32x8* y, f32x8* z)
{
    float32x4x3_t low = vld3q_f32(from), high = vld3q_f32(from + 12);
    *x = (f32x8){low.val[0], high.val[0]};
    *y = (f32x8){low.val[1], high.val[1]};
    *z = (f32x8){low.val[2], high.val[2]};
}

/// The reverse of f32x8_load_triples.
static inline void f32x8_store_triples(float* to, f32x8 x, f32x8 y, f32x8 z)
{
    const float32x4x3_t low = {{x.low, y.low, z.low}}, high = {{x.high, y.high, z.high}};
    vst3q_f32(to, low);
    vst3q_f32(to + 12, high);
}

/// Bytes of 16: each byte of `places` names one, 0..15.
static inline i32x8 i32x8_pick_bytes(const uint8_t* bytes, i32x8 places)
{
    uint8x16_t all = vld1q_u8(bytes);
    return (i32x8){vreinterpretq_s32_u8(vqtbl1q_u8(all, vreinterpretq_u8_s32(places.low))),
                   vreinterpretq_s32_u8(vqtbl1q_u8(all, vreinterpretq_u8_s32(places.high)))};
}

/// The bits of lane 0 in all lanes.
static inline i32x8 i32x8_repeat_first(i32x8 a)
{
    int32x4_t first = vdupq_laneq_s32(a.low, 0);
    return (i32x8){first, first};
}

/// Words 2 index + `word` of an array of pairs; where the mask is not set, 0, and no memory is read.
static inline i32x8 i32x8_gather_pairs(const void* pairs, int word, i32x8 index, i32x8 mask)
{
    const char* bytes = pairs;
    int32_t at[8], there[8], found[8] = {0};
    i32x8_store(at, index);
    i32x8_store(there, mask);
    for (int k = 0; k < 8; ++k) {
        if (there[k] != 0) {
            memcpy(&found[k], bytes + 4 * (2 * (int64_t)at[k] + word), sizeof(found[k]));
        }
    }
    return i32x8_load(found);
}

/// The upper halves of eight 64-bit numbers.
static inline i32x8 i32x8_load_upper(const uint64_t* from)
{
    const int32_t* words = (const int32_t*)(const void*)from;
    return (i32x8){vld2q_s32(words).val[1], vld2q_s32(words + 8).val[1]};
}

// Floats.

static inline f32x8 f32x8_add(f32x8 a, f32x8 b)
{
    return (f32x8){vaddq_f32(a.low, b.low), vaddq_f32(a.high, b.high)};
}

static inline f32x8 f32x8_sub(f32x8 a, f32x8 b)
{
    return (f32x8){vsubq_f32(a.low, b.low), vsubq_f32(a.high, b.high)};
}

static inline f32x8 f32x8_mul(f32x8 a, f32x8 b)
{
    return (f32x8){vmulq_f32(a.low, b.low), vmulq_f32(a.high, b.high)};
}

static inline f32x8 f32x8_div(f32x8 a, f32x8 b)
{
    return (f32x8){vdivq_f32(a.low, b.low), vdivq_f32(a.high, b.high)};
}

/// a where it is less than b, else b.
static inline f32x8 f32x8_min(f32x8 a, f32x8 b)
{
    return (f32x8){vbslq_f32(vcltq_f32(a.low, b.low), a.low, b.low),
                   vbslq_f32(vcltq_f32(a.high, b.high), a.high, b.high)};
}

static inline f32x8 f32x8_max(f32x8 a, f32x8 b)
{
    return (f32x8){vbslq_f32(vcgtq_f32(a.low, b.low), a.low, b.low),
                   vbslq_f32(vcgtq_f32(a.high, b.high), a.high, b.high)};
}

static inline f32x8 f32x8_root(f32x8 a)
{
    return (f32x8){vsqrtq_f32(a.low), vsqrtq_f32(a.high)};
}

static inline f32x8 f32x8_floor(f32x8 a)
{
    return (f32x8){vrndmq_f32(a.low), vrndmq_f32(a.high)};
}

/// Masks. NaN is neither less than anything nor equal to it.
static inline i32x8 f32x8_less(f32x8 a, f32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(vcltq_f32(a.low, b.low)),
                   vreinterpretq_s32_u32(vcltq_f32(a.high, b.high))};
}

static inline i32x8 f32x8_less_equal(f32x8 a, f32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(vcleq_f32(a.low, b.low)),
                   vreinterpretq_s32_u32(vcleq_f32(a.high, b.high))};
}

static inline i32x8 f32x8_equal(f32x8 a, f32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(vceqq_f32(a.low, b.low)),
                   vreinterpretq_s32_u32(vceqq_f32(a.high, b.high))};
}

/// a where the mask is set, else b.
static inline f32x8 f32x8_select(i32x8 mask, f32x8 a, f32x8 b)
{
    return (f32x8){vbslq_f32(vreinterpretq_u32_s32(mask.low), a.low, b.low),
                   vbslq_f32(vreinterpretq_u32_s32(mask.high), a.high, b.high)};
}

static inline float f32x8_lowest(f32x8 a)
{
    float32x4_t r = vbslq_f32(vcltq_f32(a.low, a.high), a.low, a.high);
    float32x2_t low = vget_low_f32(r), high = vget_high_f32(r);
    low = vbsl_f32(vclt_f32(low, high), low, high);
    float x = vget_lane_f32(low, 0), y = vget_lane_f32(low, 1);
    return x < y ? x : y;
}

static inline float f32x8_highest(f32x8 a)
{
    float32x4_t r = vbslq_f32(vcgtq_f32(a.low, a.high), a.low, a.high);
    float32x2_t low = vget_low_f32(r), high = vget_high_f32(r);
    low = vbsl_f32(vcgt_f32(low, high), low, high);
    float x = vget_lane_f32(low, 0), y = vget_lane_f32(low, 1);
    return x > y ? x : y;
}

// Integers.

static inline i32x8 i32x8_add(i32x8 a, i32x8 b)
{
    return (i32x8){vaddq_s32(a.low, b.low), vaddq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_sub(i32x8 a, i32x8 b)
{
    return (i32x8){vsubq_s32(a.low, b.low), vsubq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_mul(i32x8 a, i32x8 b)
{
    return (i32x8){vmulq_s32(a.low, b.low), vmulq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_and(i32x8 a, i32x8 b)
{
    return (i32x8){vandq_s32(a.low, b.low), vandq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_or(i32x8 a, i32x8 b)
{
    return (i32x8){vorrq_s32(a.low, b.low), vorrq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_xor(i32x8 a, i32x8 b)
{
    return (i32x8){veorq_s32(a.low, b.low), veorq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_min(i32x8 a, i32x8 b)
{
    return (i32x8){vminq_s32(a.low, b.low), vminq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_max(i32x8 a, i32x8 b)
{
    return (i32x8){vmaxq_s32(a.low, b.low), vmaxq_s32(a.high, b.high)};
}

static inline i32x8 i32x8_min_unsigned(i32x8 a, i32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(
                       vminq_u32(vreinterpretq_u32_s32(a.low), vreinterpretq_u32_s32(b.low))),
                   vreinterpretq_s32_u32(
                       vminq_u32(vreinterpretq_u32_s32(a.high), vreinterpretq_u32_s32(b.high)))};
}

static inline i32x8 i32x8_max_unsigned(i32x8 a, i32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(
                       vmaxq_u32(vreinterpretq_u32_s32(a.low), vreinterpretq_u32_s32(b.low))),
                   vreinterpretq_s32_u32(
                       vmaxq_u32(vreinterpretq_u32_s32(a.high), vreinterpretq_u32_s32(b.high)))};
}

/// Shifts by 0..31; those to the right fill with zeros.
static inline i32x8 i32x8_left(i32x8 a, int bits)
{
    return (i32x8){vshlq_s32(a.low, vdupq_n_s32(bits)), vshlq_s32(a.high, vdupq_n_s32(bits))};
}

static inline i32x8 i32x8_right(i32x8 a, int bits)
{
    return (i32x8){
        vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.low), vdupq_n_s32(-bits))),
        vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.high), vdupq_n_s32(-bits)))};
}

/// Fills with the sign.
static inline i32x8 i32x8_right_signed(i32x8 a, int bits)
{
    return (i32x8){vshlq_s32(a.low, vdupq_n_s32(-bits)), vshlq_s32(a.high, vdupq_n_s32(-bits))};
}

/// Lanes by lanes of 0..31.
static inline i32x8 i32x8_left_by(i32x8 a, i32x8 bits)
{
    return (i32x8){vshlq_s32(a.low, bits.low), vshlq_s32(a.high, bits.high)};
}

static inline i32x8 i32x8_right_by(i32x8 a, i32x8 bits)
{
    return (i32x8){
        vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.low), vnegq_s32(bits.low))),
        vreinterpretq_s32_u32(vshlq_u32(vreinterpretq_u32_s32(a.high), vnegq_s32(bits.high)))};
}

static inline i32x8 i32x8_equal(i32x8 a, i32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(vceqq_s32(a.low, b.low)),
                   vreinterpretq_s32_u32(vceqq_s32(a.high, b.high))};
}

static inline i32x8 i32x8_greater(i32x8 a, i32x8 b)
{
    return (i32x8){vreinterpretq_s32_u32(vcgtq_s32(a.low, b.low)),
                   vreinterpretq_s32_u32(vcgtq_s32(a.high, b.high))};
}

static inline i32x8 i32x8_select(i32x8 mask, i32x8 a, i32x8 b)
{
    return (i32x8){vbslq_s32(vreinterpretq_u32_s32(mask.low), a.low, b.low),
                   vbslq_s32(vreinterpretq_u32_s32(mask.high), a.high, b.high)};
}

/// How many bits of each lane are set.
static inline i32x8 i32x8_count_bits(i32x8 a)
{
    return (i32x8){
        vreinterpretq_s32_u32(vpaddlq_u16(vpaddlq_u8(vcntq_u8(vreinterpretq_u8_s32(a.low))))),
        vreinterpretq_s32_u32(vpaddlq_u16(vpaddlq_u8(vcntq_u8(vreinterpretq_u8_s32(a.high)))))};
}

static inline uint64x2_t i32x2_repeat_bytes(int32x2_t bytes, int32x2_t first, int32x2_t last)
{
    static const uint8_t spread[16] = {0, 0, 0, 0, 0, 0, 0, 0, 8, 8, 8, 8, 8, 8, 8, 8};
    const uint64x2_t all = vdupq_n_u64(UINT64_MAX);
    int64x2_t below = vmovl_s32(vshl_n_s32(first, 3));
    int64x2_t above = vmovl_s32(vsub_s32(vshl_n_s32(last, 3), vdup_n_s32(56))); // to the right
    uint64x2_t places = vandq_u64(vshlq_u64(all, below), vshlq_u64(all, above));
    uint8x16_t wide = vreinterpretq_u8_s64(vmovl_s32(bytes));
    return vandq_u64(places, vreinterpretq_u64_u8(vqtbl1q_u8(wide, vld1q_u8(spread))));
}

/// 64 bits: the byte of each lane, repeated from place `first` to place `last` (0..7, 0 the lowest),
/// of all lanes together.
static inline uint64_t i32x8_join_bytes(i32x8 bytes, i32x8 first, i32x8 last)
{
    uint64x2_t a = i32x2_repeat_bytes(vget_low_s32(bytes.low), vget_low_s32(first.low),
                                      vget_low_s32(last.low));
    uint64x2_t b = i32x2_repeat_bytes(vget_high_s32(bytes.low), vget_high_s32(first.low),
                                      vget_high_s32(last.low));
    uint64x2_t c = i32x2_repeat_bytes(vget_low_s32(bytes.high), vget_low_s32(first.high),
                                      vget_low_s32(last.high));
    uint64x2_t d = i32x2_repeat_bytes(vget_high_s32(bytes.high), vget_high_s32(first.high),
                                      vget_high_s32(last.high));
    uint64x2_t both = vorrq_u64(vorrq_u64(a, b), vorrq_u64(c, d));
    return vgetq_lane_u64(both, 0) | vgetq_lane_u64(both, 1);
}
