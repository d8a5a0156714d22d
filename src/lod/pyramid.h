// SPDX-License-Identifier: MIT
// The colour pyramid while it is made, for the files that do it: pyramid.c (colours, and the whole) and
// pyramid_coverage.c (how much of each disk is surface).
#pragma once

#include "lod/finish.h"
#include "lod/neighbours.h"
#include "lod/stencil.h"

/// One entry of the pyramid.
typedef struct stp_pyramid_entry {
    uint32_t color[3]; ///< linear, whole numbers
    uint16_t alpha;    ///< mean opacity, 65535 is 1
    uint16_t fraction; ///< how much of the disk is surface, opacity included, 65535 is 1
} stp_pyramid_entry;

typedef struct stp_pyramid_sum {
    uint64_t color[3], alpha, weight, count;
} stp_pyramid_sum;

typedef struct stp_pyramid {
    stp_context* context;
    const stp_pyramid_input* input;
    stp_surfels* surfels;
    stp_stencil stencil;
    uint32_t linear[256];
    stp_pyramid_entry* octaves[STP_OCTAVE_LIMIT]; ///< entries of each octave, in one array
    uint16_t* fractions[STP_OCTAVE_LIMIT];        ///< the same fractions, as columns for searches
    stp_pyramid_entry* entries;
    uint16_t* fraction_column;
    stp_pyramid_sum* sums;
    stp_grid candidates; ///< all, in cells made for the finest octave
    uint32_t* nearest;   ///< of each sample, in its grid's order
    stp_disk* disks;
    uint32_t*
        visit; ///< the surfels of one prefix along a space-filling curve; from the longest prefix on
    uint32_t visit_count;
} stp_pyramid;

/// How an octave is made.
typedef struct stp_octave_plan {
    float radius;         ///< to what its prefix covers
    float disk_radius;    ///< of the disks drawn with it
    uint32_t dense_count; ///< surfels that sample the disks; 0: every stride-th candidate does
    uint32_t stride;
    float cell; ///< of the grids
} stp_octave_plan;

static inline uint16_t stp_pyramid_fraction(double value)
{
    return (uint16_t)(value * 65535.0 + 0.5);
}

/// How an octave is made: what samples its disks, and the cells to look in.
void stp_pyramid_plan_octave(const stp_pyramid* p, uint32_t octave, stp_octave_plan* plan);

/// Fills the fractions of the finest octave, whose entries have their opacities. `p->candidates` is there.
void stp_pyramid_cover_finest(stp_pyramid* p, uint32_t octave, const stp_octave_plan* plan);
/// The same of another octave; finer ones are done.
STP_MUST_USE stp_result stp_pyramid_cover_coarser(stp_pyramid* p, uint32_t octave,
                                                  const stp_octave_plan* plan);
