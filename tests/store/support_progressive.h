// SPDX-License-Identifier: MIT
// Progressive sets for tests: random ones, and ones from a merge forest over a bumpy surface.
#pragma once

#include "base/core/arena.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_columns.h"

typedef struct progressive_desc {
    uint64_t seed;
    uint32_t base, splits;
    bool coarse; ///< few distinct levels
    bool wild;   ///< columns other than ranges are random bytes
} progressive_desc;

/// Makes a valid set. @return false if memory runs out or the seed does not lead to all splits
bool progressive_sample_make(stp_arena* arena, const progressive_desc* desc, stp_splats* set);

/// Makes a set from the merge forest over `count` coloured points of a bumpy surface: a complete
/// set with base and operators.
bool progressive_sample_of_forest(stp_arena* arena, stp_context* context, uint32_t count,
                                  uint32_t base, stp_splats* set);

/// Octaves of a set: the first ends after `first` splats, each further one after four times as
/// many, the last with the set.
void progressive_sample_octaves(stp_splats* set, uint32_t first);

/// Marks the splats of the state with `wanted` splats, or of the nearest one, by definition: those of
/// a prefix without the parents of its splits.
/// @param counts of all splats that may be drawn
/// @param order  from stp_progressive_order
/// @param marks  true or false for each splat of the prefix
/// @return splats of the state
uint32_t progressive_sample_mark(stp_progressive_counts counts, const uint32_t* order,
                                 uint32_t wanted, bool* marks);

/// A set of the same size whose columns are all zeros.
bool progressive_sample_empty(stp_arena* arena, const stp_splats* like, stp_splats* set);
bool progressive_sample_is_same(const stp_splats* a, const stp_splats* b, uint32_t count);
