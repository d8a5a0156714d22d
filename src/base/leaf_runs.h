// SPDX-License-Identifier: MIT
// Which splats of a set belong to which of its leaves.
//
// Put all splats in one row, leaf after leaf, each leaf's in its random order. Of a set of K octaves, octave k and those before
// it hold every 4^(K - 1 - k)th place of the row. So each leaf has its share of each octave, to within one splat, and the
// octaves' ends and all runs follow from the leaves' counts.
//
//   octave 0   | leaf 0 | leaf 1 | ...            a sixteenth of each, of three octaves
//   octave 1   | leaf 0     | leaf 1      | ...   three sixteenths
//   octave 2   | leaf 0            | leaf 1             | ...
#pragma once

#include <stdint.h>

enum {
    STP_LEAF_FIRST_MOST = 64, ///< an octave 0 is smaller than this
};

/// Octaves of a set of `count` splats, at least 1: so many that the first one has 16 to 63 of them, or all.
static inline uint32_t stp_leaf_octaves(uint32_t count)
{
    uint32_t octaves = 1;
    while (count >> 2 * (octaves - 1) >= STP_LEAF_FIRST_MOST) {
        octaves += 1;
    }
    return octaves;
}

/// How many of the first `place` splats of the row are in octave k of K, or before it.
static inline uint32_t stp_leaf_until(uint32_t place, uint32_t octave, uint32_t octaves)
{
    return place >> 2 * (octaves - 1 - octave);
}

/// The octave that a place of the row is in: of K. `place` counts from 1.
static inline uint32_t stp_leaf_octave_of(uint32_t place, uint32_t octaves)
{
    uint32_t octave = octaves - 1;
    while (octave > 0 && (place & 3u) == 0) {
        place >>= 2;
        octave -= 1;
    }
    return octave;
}

/// Splats of the set.
typedef struct stp_leaf_run {
    uint32_t begin, end;
} stp_leaf_run;

/// The splats of octave k that the places [first, last) of the row have, of a set of K octaves and `count` splats.
static inline stp_leaf_run stp_leaf_run_of(uint32_t first, uint32_t last, uint32_t octave,
                                           uint32_t octaves, uint32_t count)
{
    if (octave == 0) {
        return (stp_leaf_run){stp_leaf_until(first, 0, octaves), stp_leaf_until(last, 0, octaves)};
    }
    // before this octave are the octaves before it, whole; within it those places that are not theirs
    uint32_t before = stp_leaf_until(count, octave - 1, octaves);
    uint32_t begin =
        stp_leaf_until(first, octave, octaves) - stp_leaf_until(first, octave - 1, octaves);
    uint32_t end =
        stp_leaf_until(last, octave, octaves) - stp_leaf_until(last, octave - 1, octaves);
    return (stp_leaf_run){before + begin, before + end};
}
