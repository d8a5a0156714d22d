// SPDX-License-Identifier: MIT
// Eight floats at a time in plain C, for CPUs without a variant of their own. vector.h and
// vector_avx512.h define the same names: `wide` for leaves, `eight` for branches.
#pragma once

#include <assert.h>
#include <math.h>
#include <stdint.h>

typedef struct eight {
    float lane[8];
} eight;

#define EACH_LANE for (int i_ = 0; i_ < 8; ++i_)

static inline eight eight_load(const float* from)
{
    eight r;
    assert(((uintptr_t)from & 31) == 0 && "vector variants need this alignment");
    EACH_LANE r.lane[i_] = from[i_];
    return r;
}

static inline void eight_store(float* to, eight a)
{
    EACH_LANE to[i_] = a.lane[i_];
}

static inline eight eight_set(float value)
{
    eight r;
    EACH_LANE r.lane[i_] = value;
    return r;
}

static inline eight eight_add(eight a, eight b)
{
    EACH_LANE a.lane[i_] += b.lane[i_];
    return a;
}

static inline eight eight_sub(eight a, eight b)
{
    EACH_LANE a.lane[i_] -= b.lane[i_];
    return a;
}

static inline eight eight_mul(eight a, eight b)
{
    EACH_LANE a.lane[i_] *= b.lane[i_];
    return a;
}

static inline eight eight_min(eight a, eight b)
{
    EACH_LANE a.lane[i_] = a.lane[i_] < b.lane[i_] ? a.lane[i_] : b.lane[i_];
    return a;
}

static inline eight eight_max(eight a, eight b)
{
    EACH_LANE a.lane[i_] = a.lane[i_] > b.lane[i_] ? a.lane[i_] : b.lane[i_];
    return a;
}

static inline eight eight_root(eight a)
{
    EACH_LANE a.lane[i_] = sqrtf(a.lane[i_]);
    return a;
}

static inline uint32_t eight_less(eight a, eight b)
{
    uint32_t mask = 0;
    EACH_LANE mask |= (uint32_t)(a.lane[i_] < b.lane[i_]) << i_;
    return mask;
}

static inline uint32_t eight_equal(eight a, eight b)
{
    uint32_t mask = 0;
    EACH_LANE mask |= (uint32_t)(a.lane[i_] == b.lane[i_]) << i_;
    return mask;
}

/// a where the mask's bit is 0, b where it is 1.
static inline eight eight_blend(eight a, eight b, uint32_t mask)
{
    EACH_LANE a.lane[i_] = (mask >> i_ & 1) != 0 ? b.lane[i_] : a.lane[i_];
    return a;
}

static inline float eight_highest(eight a)
{
    float r = a.lane[0];
    EACH_LANE r = r > a.lane[i_] ? r : a.lane[i_];
    return r;
}

static inline float eight_lowest(eight a)
{
    float r = a.lane[0];
    EACH_LANE r = r < a.lane[i_] ? r : a.lane[i_];
    return r;
}

#undef EACH_LANE

#include "order/vector_eight.h" // IWYU pragma: export
