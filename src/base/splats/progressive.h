// SPDX-License-Identifier: MIT
//
// Sets of splats that are refined and coarsened one split at a time (Wu, Zhang, Kobbelt 2005, 5).
// Their order and their ranges of levels imply which splat each split replaces:
//
//   splats  [0 .. base) | 2 of split 0 | 2 of split 1 | ...
//
// A splat whose lowest level is 0 is a leaf. All others are parents. Split s replaces parent s of
// the split order: parents are sorted by descending lowest level; ties by index. Splats of the base
// set are drawn up to an infinite level, all others up to a finite one. A child's lowest level is
// at most its parent's. So any prefix of a set is a valid set with fewer splits.
#pragma once

#include <stdbool.h>
#include <stdint.h>

/// Role counts of the splats in a prefix.
typedef struct stp_progressive_counts {
    uint32_t base;   ///< splats in the base set
    uint32_t splits; ///< splits whose two splats are both in the prefix
    /// Splats that are not leaves; equal to `splits` in a whole set, otherwise at least `splits`
    uint32_t parents;
} stp_progressive_counts;

/// Counts the base set, the splits and the parents in the first `count` splats of a set.
/// @param ranges codes of ranges (base/splats/splat_codes.h), 1 per splat
stp_progressive_counts stp_progressive_count(const uint32_t* ranges, uint32_t count);

/// Lists all parents in split order: parent s is the splat that split s replaces.
/// @param order room for `count` indices
/// @param scratch room for `count` indices
/// @return number of parents
uint32_t stp_progressive_order(const uint32_t* ranges, uint32_t count, uint32_t* order,
                               uint32_t* scratch);

/// Whether a splat may be a child of another, by the ranges of the two.
bool stp_progressive_fits(uint32_t parent, uint32_t child);

/// Checks that a prefix of a set can be split in its order: all levels are valid, each parent
/// precedes its two children and its lowest level is at least theirs, and there are enough parents.
/// @param order from stp_progressive_order
/// @return whether all of this holds
bool stp_progressive_is_valid(const uint32_t* ranges, uint32_t count, const uint32_t* order);
/// Also checks that the set is whole: there are no more parents than splits.
bool stp_progressive_is_whole(const uint32_t* ranges, uint32_t count, const uint32_t* order);

/// A state with some count of splats as two runs of the set, each drawn at one level. With lo the
/// lowest level of a splat as a code, splat i < end is drawn if lo < code, or if lo = code and i >=
/// divide.
typedef struct stp_progressive_cut {
    uint32_t end;    ///< splats of the prefix that holds the state
    uint32_t code;   ///< code of the lowest level of the next split's parent; 0: nothing to split
    uint32_t divide; ///< index of that parent; 0 if nothing is left to split
    float below;     ///< the level at which splats [0, divide) are drawn
    float level;     ///< the level at which splats [divide, end) are drawn
    uint32_t splats; ///< splats of the state: the requested number, clamped to the prefix
} stp_progressive_cut;

/// Finds the state with `wanted` splats, or the nearest that the prefix has. Takes time in
/// proportion to `count`, and no memory. The two levels suit a test that draws a splat if lowest <=
/// level <= highest, with bounds as stp_range_level gives them.
/// @param ranges of a valid prefix of a set
stp_progressive_cut stp_progressive_find_cut(const uint32_t* ranges, uint32_t count,
                                             uint32_t wanted);

/// The parents waiting to be split while a set is read in its order.
typedef struct stp_progressive_queue {
    const uint32_t* ranges;
    uint32_t* heap; ///< owned by the caller: space for all parents that may wait
    uint32_t count;
} stp_progressive_queue;

/// Starts with the parents of a prefix, minus those of the first `done` splits.
/// @param heap room for `count` indices, and for one more with each splat that is added
stp_progressive_queue stp_progressive_queue_begin(const uint32_t* ranges, uint32_t count,
                                                  uint32_t done, uint32_t* heap);
/// Adds a splat, unless it is a leaf.
void stp_progressive_queue_add(stp_progressive_queue* queue, uint32_t splat);
/// Removes the parent that is split next; UINT32_MAX if none waits.
uint32_t stp_progressive_queue_take(stp_progressive_queue* queue);
