// SPDX-License-Identifier: MIT
//
// A seeded stream of random numbers. Streams of different seeds are independent. Give each item
// that another thread may create its own stream (random_fork).
#pragma once

#include "base/math/rng.h"

typedef struct random_stream {
    uint64_t seed, index;
} random_stream;

static inline random_stream random_begin(uint64_t seed)
{
    return (random_stream){stp_rng_hash(seed, UINT64_C(0x5ce9e)), 0};
}

/// A stream for item `number`; the parent does not advance.
static inline random_stream random_fork(const random_stream* parent, uint64_t number)
{
    return (random_stream){stp_rng_hash(parent->seed ^ UINT64_C(0xf02c), number), 0};
}

static inline uint64_t random_bits(random_stream* random)
{
    return stp_rng_hash(random->seed, random->index++);
}

/// Uniform in [0, 1).
static inline double random_unit(random_stream* random)
{
    return (double)(random_bits(random) >> 11) * (1.0 / 9007199254740992.0);
}

/// Uniform in [low, high).
static inline double random_between(random_stream* random, double low, double high)
{
    return low + (high - low) * random_unit(random);
}

/// Uniform in [0, bound); bound > 0.
static inline uint32_t random_below(random_stream* random, uint32_t bound)
{
    return stp_rng_below(random->seed, random->index++, bound);
}
