// SPDX-License-Identifier: MIT
//
// The two dominant searches of finishing: for each sample the nearest surfel, and for each surfel
// the samples in its disk.
#pragma once

#include "lod/blue/stencil.h"
#include "lod/grid.h"

/// For each sample, the nearest surfel on its side; the lower index on ties.
typedef struct stp_nearest_search {
    const stp_grid* surfels; ///< cells at least twice `radius` wide; offset 0
    /// The same cells, offset by half a cell: samples of one cell see the same surfels
    const stp_grid* samples;
    float radius;   ///< maximum distance of a surfel
    bool two_sided; ///< ignores the sign of normals
    /// Result: per sample, in the grid's order; UINT32_MAX: none within `radius`
    uint32_t* nearest;
} stp_nearest_search;

/// Searches on all threads. Results do not depend on their number.
void stp_nearest_search_run(stp_context* context, const stp_nearest_search* search);

/// Content of a surfel's disk.
typedef struct stp_disk {
    uint64_t cells;     ///< cells of the stencil
    uint64_t fractions; ///< sum over the samples
    uint32_t count;     ///< number of samples, weighted
    bool full;          ///< with `until_full`, count and sum are then undefined
} stp_disk;

/// For each surfel, the samples in its disk.
typedef struct stp_disk_search {
    const stp_grid* samples;
    const uint16_t* fractions; ///< value of each sample for the sum, by index; NULL: none
    float footprint;           ///< half the side of the square that a sample represents; 0: a point
    uint32_t set_count;        ///< the last samples, by index, are splats of sets; their number
    uint32_t sample_count;     ///< number of all samples, if some are of sets
    float set_footprint;       ///< half side for samples of sets; at most `footprint`
    uint32_t set_weight;       ///< weight of samples of sets
    const float* positions;    ///< 3 per surfel
    const float* normals;      ///< 3 per surfel
    const uint32_t* visit;     ///< surfels to visit, best in a spatially coherent order
    uint32_t count;            ///< number of surfels in `visit`
    float radius;              ///< radius of the disks, above 0
    bool two_sided;            ///< ignores the sign of normals
    bool until_full;           ///< stop once a disk is known to be full
    const stp_stencil* stencil;
    stp_disk* disks; ///< result: content of the disk of each visited surfel, by its index
} stp_disk_search;

void stp_disk_search_run(stp_context* context, const stp_disk_search* search);
