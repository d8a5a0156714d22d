// SPDX-License-Identifier: MIT
// Eight floats at a time, with AVX2 or NEON. Same names and bits as vector_portable.h.
#pragma once

#include "base/math/f32x8.h"

typedef f32x8 eight;
#define eight_load f32x8_load
#define eight_store f32x8_store
#define eight_set f32x8_set
#define eight_add f32x8_add
#define eight_sub f32x8_sub
#define eight_mul f32x8_mul
#define eight_min f32x8_min
#define eight_max f32x8_max
#define eight_root f32x8_root
#define eight_highest f32x8_highest
#define eight_lowest f32x8_lowest

static inline uint32_t eight_less(eight a, eight b)
{
    return i32x8_signs(f32x8_less(a, b));
}

static inline uint32_t eight_equal(eight a, eight b)
{
    return i32x8_signs(f32x8_equal(a, b));
}

static inline eight eight_blend(eight a, eight b, uint32_t mask)
{
    static const int32_t places[8] = {1, 2, 4, 8, 16, 32, 64, 128};
    i32x8 bits = i32x8_load(places);
    i32x8 chosen = i32x8_and(i32x8_set((int32_t)mask), bits);
    return f32x8_select(i32x8_equal(chosen, bits), b, a);
}
#ifndef STP_WIDE_16
#include "order/vector_eight.h" // IWYU pragma: export
#endif
