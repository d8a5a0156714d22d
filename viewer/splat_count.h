// SPDX-License-Identifier: MIT
//
// How many splats a scene can be drawn with, where their number is chosen instead of their size
// (stp_quality.splat_count).
#pragma once

#include "store/store.h"

enum { SPLAT_COUNT_LEAST = 2 };
/// A view draws no more things.
#define SPLAT_COUNT_MOST 4294967294u

/// The most splats that a view of the whole scene draws by number: those of the uppermost set on each
/// way down from the root, and of the uppermost sets of what moves. Instances count each. Of sets of
/// `psp` that count, the first octaves are read.
/// @param method a place in the directory's table
/// @return at most SPLAT_COUNT_MOST; 0 if the method has no sets there, a set cannot be read, or
///         memory runs out
uint32_t splat_count_of_scene(stp_store* store, uint32_t method);

/// Whether there is a choice of numbers.
static inline bool splat_count_is_chosen_of(uint32_t all)
{
    return all > SPLAT_COUNT_LEAST;
}

/// A number from SPLAT_COUNT_LEAST to `all`.
uint32_t splat_count_within(uint64_t count, uint32_t all);

/// The next number up or down: twice or half as many; if `fine`, a twentieth more or less, and one at
/// least.
uint32_t splat_count_step(uint32_t count, uint32_t all, bool up, bool fine);
