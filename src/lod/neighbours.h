// SPDX-License-Identifier: MIT
//
// The two searches that finishing spends its time on: for each sample the surfel whose cell it lies in, and
// for each surfel what lies in its disk.
#pragma once

#include "lod/blue/stencil.h"
#include "lod/grid.h"

/// For each sample the nearest surfel: of those on its side, the lower index where two are as near.
typedef struct stp_nearest_search {
    const stp_grid* surfels; ///< cells twice `radius` wide or wider; offset 0
    const stp_grid*
        samples; ///< the same cells, offset by half a cell: samples of one cell see the same surfels
    float radius;      ///< how far a surfel may be away
    bool two_sided;    ///< normals do not tell sides apart
    uint32_t* nearest; ///< result: of each sample in the grid's order; UINT32_MAX: none in reach
} stp_nearest_search;

/// Searches on all threads. Results do not depend on their number.
void stp_nearest_search_run(stp_context* context, const stp_nearest_search* search);

/// What was found in a surfel's disk.
typedef struct stp_disk {
    uint64_t cells;     ///< of the stencil
    uint64_t fractions; ///< sum over the samples
    uint32_t count;     ///< of samples
    bool full;          ///< where asked to stop at that, count and sum mean nothing
} stp_disk;

/// For each surfel the samples in its disk.
typedef struct stp_disk_search {
    const stp_grid* samples;
    const uint16_t* fractions; ///< what each sample adds to the sum, by its index; NULL: nothing
    float footprint;           ///< half the side of the square that a sample stands for; 0: a point
    uint32_t set_count;        ///< the last samples by index, so many, are surfels of sets
    uint32_t sample_count;     ///< of all by index, where there are some of sets
    float set_footprint;       ///< of those; at most `footprint`
    uint32_t set_weight;       ///< they count so many times
    const float* positions;    ///< 3 a surfel
    const float* normals;      ///< 3 a surfel
    const uint32_t* visit;     ///< which surfels, best in an order that keeps near what is near
    uint32_t count;            ///< of `visit`
    float radius;              ///< of the disks
    bool two_sided;            ///< normals do not tell sides apart
    bool until_full;           ///< stop where a disk is known to be full
    const stp_stencil* stencil;
    stp_disk* disks; ///< result: of each surfel visited, by its index
} stp_disk_search;

void stp_disk_search_run(stp_context* context, const stp_disk_search* search);
