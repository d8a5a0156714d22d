// SPDX-License-Identifier: MIT
// The inner loops of the searches. Every variant gives the same bits.
#pragma once

#include "lod/neighbours.h"

enum {
    STP_NEAR_LANES = 8,       ///< samples looked at together
    STP_NEAR_RANGE_LIMIT = 8, ///< 2 x 2 x 2 cells
};

/// Where the surfels stand that some samples may be near to.
typedef struct stp_near_ranges {
    uint32_t count;
    uint32_t begins[STP_NEAR_RANGE_LIMIT], ends[STP_NEAR_RANGE_LIMIT];
} stp_near_ranges;

typedef struct stp_near_findings {
    uint32_t surfel[STP_NEAR_LANES];
    float squared[STP_NEAR_LANES]; ///< distances
} stp_near_findings;

/// A disk that is looked for samples.
typedef struct stp_disk_query {
    float x, y, z, nx, ny, nz;
    float limit;           ///< squared distance
    float least_agreement; ///< of normals
    stp_vec3 tangents[2];  ///< over the disk's radius
    float footprint;       ///< half the side of a sample's square, over the radius
    float set_footprint;   ///< of those from `first_of_sets` on, by index
    uint32_t first_of_sets;
} stp_disk_query;

typedef struct stp_disk_hits {
    uint32_t near;   ///< bit i: sample begin + i lies in the disk
    uint32_t of_set; ///< those of sets
    uint64_t cells;  ///< of the stencil
} stp_disk_hits;

typedef struct stp_near_kernels {
    /// The nearest surfel of each of STP_NEAR_LANES samples from `at` on, or what was `found` before where none is
    /// nearer. Of two as near, the lower index.
    void (*find_nearest)(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t at, float least_agreement,
                         stp_near_findings* found);
    /// Which samples of [begin, end) of the columns are in a disk: at most STP_NEAR_LANES are looked at.
    stp_disk_hits (*test_samples)(const stp_grid* samples, uint32_t begin, uint32_t end,
                                  const stp_disk_query* query);
} stp_near_kernels;

extern const stp_near_kernels stp_near_kernels_portable;
extern const stp_near_kernels stp_near_kernels_avx2;
