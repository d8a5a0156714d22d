// SPDX-License-Identifier: MIT
//
// One walk over many samples that finds for each the surfel whose cell it lies in, and for each
// surfel what lies in its disk. It is where finishing spends its time.
#pragma once

#include "lod/grid.h"

#include <stdatomic.h>

enum { STP_SUM_SHIFT = 40 };

typedef struct stp_neighbour_walk {
    // the samples: candidates, or the surfels of a longer prefix
    const float* positions; ///< 3 a sample
    const float* normals;   ///< 3 a sample
    uint32_t count;
    uint32_t stride;           ///< every stride-th sample is walked
    float footprint;           ///< half the side of the square that a sample stands for; 0: a point
    const uint16_t* fractions; ///< what each sample adds to `sums`; NULL: nothing

    // the surfels
    const stp_grid* grid; ///< over a prefix
    const float* frames;  ///< 6 a surfel: two tangents of unit length; NULL: disks are not wanted
    float disk_radius;
    uint64_t disk_cells;  ///< of the stencil: what makes a disk full; all: nothing does
    float nearest_radius; ///< how far a cell reaches at most
    bool two_sided;       ///< normals do not tell sides apart

    // results
    uint32_t*
        nearest; ///< surfel of each sample, UINT32_MAX where none is in reach; NULL: not wanted
    _Atomic uint64_t* disks; ///< stencil cells hit in each surfel's disk; zero before
    /// Of the samples in each surfel's disk: (count << STP_SUM_SHIFT) + the sum of their fractions;
    /// zero before; NULL: not wanted. Not counted to the end where the disk is full.
    _Atomic uint64_t* sums;
} stp_neighbour_walk;

/// Walks on all threads. Results do not depend on their number, but for sums of full disks.
void stp_neighbour_walk_run(stp_context* context, const stp_neighbour_walk* walk);
