// SPDX-License-Identifier: MIT
//
// The number of splats of a scene, if they are drawn by number instead of size
// (stp_quality.splat_count).
#pragma once

#include "store/file/store.h"

enum { SPLAT_COUNT_MIN = 2 };
/// A view draws at most this many splats.
#define SPLAT_COUNT_MAX 4294967294u

/// The maximum number of splats that a view of the whole scene draws by number: the sum of the
/// uppermost sets on each path from the root, and of the uppermost sets of moving parts. Each
/// instance counts. Reads the first octaves of the `psp` sets that count.
/// @param method index in the directory's table
/// @return at most SPLAT_COUNT_MAX; 0 if the method has no sets there, a set cannot be read, or
///         memory runs out
uint32_t splat_count_of_scene(stp_store* store, uint32_t method);

/// Whether a number can be chosen.
static inline bool splat_count_is_chosen_of(uint32_t all)
{
    return all > SPLAT_COUNT_MIN;
}

/// A number from SPLAT_COUNT_MIN to `all`.
uint32_t splat_count_within(uint64_t count, uint32_t all);

/// The next number up or down: twice or half as many; if `fine`, 5 % more or less, but at least
/// one.
uint32_t splat_count_step(uint32_t count, uint32_t all, bool up, bool fine);
