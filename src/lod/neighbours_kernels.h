// SPDX-License-Identifier: MIT
// The inner loops of the searches. Every variant gives the same bits.
#pragma once

#include "lod/neighbours.h"

enum { STP_NEAR_LIMIT = 512 }; ///< surfels looked at together

/// Surfels of a block, side by side; columns are padded with points that are never near.
typedef struct stp_near_surfels {
    uint32_t count;
    uint32_t index[STP_NEAR_LIMIT];
    float x[STP_NEAR_LIMIT], y[STP_NEAR_LIMIT], z[STP_NEAR_LIMIT];
    float nx[STP_NEAR_LIMIT], ny[STP_NEAR_LIMIT], nz[STP_NEAR_LIMIT];
} stp_near_surfels;

/// A place with a side.
typedef struct stp_near_query {
    float x, y, z, nx, ny, nz;
    float limit;           ///< squared distance
    float least_agreement; ///< of normals
} stp_near_query;

typedef struct stp_near_finding {
    uint32_t surfel;
    float squared;
} stp_near_finding;

typedef struct stp_near_kernels {
    /// The nearest of the surfels, or `found` where none is nearer.
    stp_near_finding (*find_nearest)(const stp_near_surfels* surfels, const stp_near_query* query,
                                     stp_near_finding found);
    /// Which samples of [begin, end) of the columns are near: at most STP_GRID_LANES are looked at.
    /// Bit i: sample begin + i.
    uint32_t (*test_samples)(const stp_grid* samples, uint32_t begin, uint32_t end,
                             const stp_near_query* query);
    uint32_t lanes; ///< samples that test_samples looks at
} stp_near_kernels;

extern const stp_near_kernels stp_near_kernels_portable;
extern const stp_near_kernels stp_near_kernels_avx2;

static inline stp_near_finding stp_nearer(stp_near_finding found, uint32_t surfel, float squared)
{
    bool nearer = squared < found.squared || (squared == found.squared && surfel < found.surfel);
    return nearer ? (stp_near_finding){.surfel = surfel, .squared = squared} : found;
}
