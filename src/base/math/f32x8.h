// SPDX-License-Identifier: MIT
//
// Eight floats (f32x8) or integers (i32x8) at a time: kernels that are written once, for AVX2 and
// for NEON. Only for files compiled for one of them. Each operation is one IEEE or two's complement
// operation for each lane, so both give the bits of plain C. A mask is an i32x8 of lanes 0 and -1.
#pragma once

#if defined(__AVX2__)
#include "base/math/f32x8_avx2.h" // IWYU pragma: export
#elif defined(__aarch64__)
#include "base/math/f32x8_neon.h" // IWYU pragma: export
#else
#error "no vectors of eight numbers; compile the portable kernels only"
#endif

static inline f32x8 f32x8_negate(f32x8 a)
{
    return i32x8_as_float(i32x8_xor(f32x8_as_int(a), i32x8_set(INT32_MIN)));
}

static inline f32x8 f32x8_magnitude(f32x8 a)
{
    return i32x8_as_float(i32x8_and(f32x8_as_int(a), i32x8_set(INT32_MAX)));
}

/// Zero where the mask is.
static inline f32x8 f32x8_keep(f32x8 a, i32x8 mask)
{
    return i32x8_as_float(i32x8_and(f32x8_as_int(a), mask));
}

/// 0, 1, 2 and so on.
static inline i32x8 i32x8_index(void)
{
    static const int32_t index[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    return i32x8_load(index);
}

/// Three floats at a time, by columns; sums in the order of `a.x * b.x + a.y * b.y + a.z * b.z`.
typedef struct vector3x8 {
    f32x8 x, y, z;
} vector3x8;

static inline vector3x8 vector3x8_set(float x, float y, float z)
{
    return (vector3x8){f32x8_set(x), f32x8_set(y), f32x8_set(z)};
}

static inline vector3x8 vector3x8_load(const float* x, const float* y, const float* z)
{
    return (vector3x8){f32x8_load(x), f32x8_load(y), f32x8_load(z)};
}

static inline vector3x8 vector3x8_subtract(vector3x8 a, vector3x8 b)
{
    return (vector3x8){f32x8_sub(a.x, b.x), f32x8_sub(a.y, b.y), f32x8_sub(a.z, b.z)};
}

static inline f32x8 vector3x8_dot(vector3x8 a, vector3x8 b)
{
    f32x8 sum = f32x8_add(f32x8_mul(a.x, b.x), f32x8_mul(a.y, b.y));
    return f32x8_add(sum, f32x8_mul(a.z, b.z));
}

/// Eight consecutive vectors.
static inline vector3x8 vector3x8_load_triples(const float* from)
{
    vector3x8 v;
    f32x8_load_triples(from, &v.x, &v.y, &v.z);
    return v;
}
