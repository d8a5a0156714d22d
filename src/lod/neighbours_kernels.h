// SPDX-License-Identifier: MIT
// The inner loops of the searches. Every variant gives the same bits.
#pragma once

#include "lod/neighbours.h"

#include <assert.h>

enum {
    STP_NEAR_LANES = 8,        ///< samples tested together
    STP_NEAR_RANGE_LIMIT = 40, ///< 2 x 2 x 2 cells of surfels, rows of 4 x 4 x 4 cells of samples
};

/// Points of a grid, in a few ranges.
typedef struct stp_near_ranges {
    uint32_t count;
    uint32_t begins[STP_NEAR_RANGE_LIMIT], ends[STP_NEAR_RANGE_LIMIT];
} stp_near_ranges;

static inline void stp_near_ranges_add(stp_near_ranges* ranges, uint32_t begin, uint32_t end)
{
    assert(begin <= end && ranges->count < STP_NEAR_RANGE_LIMIT);
    ranges->begins[ranges->count] = begin;
    ranges->ends[ranges->count] = end;
    ranges->count += begin != end;
}

/// Search parameters for surfels near a sample.
typedef struct stp_near_rule {
    float limit;         ///< maximum squared distance
    float min_agreement; ///< minimum dot product of both normals
} stp_near_rule;

/// A disk whose samples are searched.
typedef struct stp_disk_query {
    float x, y, z, nx, ny, nz;
    float limit;          ///< maximum squared distance
    float min_agreement;  ///< minimum dot product of both normals
    stp_vec3 tangents[2]; ///< axes of the disk's plane, divided by its radius
    float footprint;      ///< half the side of a sample's square, over the radius
    float set_footprint;  ///< the same for samples from index `first_of_sets` on
    uint32_t first_of_sets;
    uint32_t set_weight;
    const uint16_t* fractions; ///< by index, or NULL
    const stp_stencil* stencil;
    bool until_full;
} stp_disk_query;

typedef struct stp_near_kernels {
    /// @return end of the run of samples in [begin, end) that lie in the cell of the first
    uint32_t (*find_run)(const stp_grid* samples, uint32_t begin, uint32_t end);
    /// Nearest surfel for each of the samples [begin, end), UINT32_MAX if none is near; the lower
    /// index on ties.
    void (*find_nearest)(const stp_grid* surfels, const stp_near_ranges* ranges,
                         const stp_grid* samples, uint32_t begin, uint32_t end, stp_near_rule rule,
                         uint32_t* nearest);
    /// Adds samples in a disk to its content. @return whether the disk is known to be full, and
    /// finished
    bool (*scan_disk)(const stp_grid* samples, const stp_near_ranges* ranges,
                      const stp_disk_query* query, stp_disk* disk);
    /// Minimum squared distance from a position to `count` points, a multiple of STP_NEAR_LANES; at
    /// most FLT_MAX.
    float (*nearest_squared)(const float* x, const float* y, const float* z, uint32_t count,
                             stp_vec3 place);
} stp_near_kernels;

/// The kernels for this CPU.
const stp_near_kernels* stp_near_kernels_select(void);

extern const stp_near_kernels stp_near_kernels_portable;
extern const stp_near_kernels stp_near_kernels_vector;
