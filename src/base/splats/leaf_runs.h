// SPDX-License-Identifier: MIT
// Which splats of a set belong to which of its leaves.
//
// Put all splats in one row, leaf after leaf, each leaf's in its random order. With K octaves,
// octaves 0 to k hold every 4^(K - 1 - k)th place of the row. So each leaf has its share of each
// octave to within one splat, and the counts of the leaves determine the ends of the octaves and
// all runs.
//
//   octave 0   | leaf 0 | leaf 1 | ...            with three octaves: a sixteenth of each
//   octave 1   | leaf 0     | leaf 1      | ...   three sixteenths
//   octave 2   | leaf 0            | leaf 1             | ...
#pragma once

#include <assert.h>
#include <stdint.h>

enum {
    STP_LEAF_FIRST_MAX = 64, ///< an octave 0 is smaller than this
};

/// Number of octaves of a set of `count` splats, at least 1. Chosen so that the first has 16 to 63
/// of them, or all.
static inline uint32_t stp_leaf_octaves(uint32_t count)
{
    uint32_t octaves = 1;
    while (count >> 2 * (octaves - 1) >= STP_LEAF_FIRST_MAX) {
        octaves += 1;
    }
    return octaves;
}

/// How many of the first `place` splats of the row are in octaves 0 to `octave`.
static inline uint32_t stp_leaf_until(uint32_t place, uint32_t octave, uint32_t octaves)
{
    assert(octave < octaves && octaves <= 16);
    return place >> 2 * (octaves - 1 - octave);
}

/// Octave of a place in the row. `place` counts from 1.
static inline uint32_t stp_leaf_octave_of(uint32_t place, uint32_t octaves)
{
    uint32_t octave = octaves - 1;
    assert(place > 0 && octaves > 0 && "places count from 1");
    while (octave > 0 && (place & 3u) == 0) {
        place >>= 2;
        octave -= 1;
    }
    return octave;
}

/// A run of splats of the set.
typedef struct stp_leaf_run {
    uint32_t begin, end;
} stp_leaf_run;

/// Splats of one octave at places [first, last) of the row, in a set of `octaves` octaves and
/// `count` splats.
static inline stp_leaf_run stp_leaf_run_of(uint32_t first, uint32_t last, uint32_t octave,
                                           uint32_t octaves, uint32_t count)
{
    assert(first <= last && last <= count);
    if (octave == 0) {
        return (stp_leaf_run){stp_leaf_until(first, 0, octaves), stp_leaf_until(last, 0, octaves)};
    }
    // earlier octaves come first, whole; within this octave, count the places that earlier ones do
    // not own
    uint32_t before = stp_leaf_until(count, octave - 1, octaves);
    uint32_t begin =
        stp_leaf_until(first, octave, octaves) - stp_leaf_until(first, octave - 1, octaves);
    uint32_t end =
        stp_leaf_until(last, octave, octaves) - stp_leaf_until(last, octave - 1, octaves);
    return (stp_leaf_run){before + begin, before + end};
}
