// SPDX-License-Identifier: MIT
//
// Points in the buckets of a hashed grid, as columns: bucket by bucket, in ascending order within
// each. Hash collisions only add points that are too far away for a query.
#pragma once

#include "base/core/context.h"

enum { STP_GRID_LANES = 16 }; ///< columns may be read in blocks of this many points, past their end

typedef struct stp_grid {
    uint32_t count;
    float cell, inverse_cell; ///< side of a cell, and its reciprocal
    float offset;             ///< cells begin at multiples of `cell`, plus this on each axis
    uint32_t mask;            ///< number of buckets - 1
    uint32_t* starts;         ///< first point of each bucket in the columns, and the end
    uint32_t* index;          ///< index of each point in the given arrays
    float *x, *y, *z;         ///< positions and normals, in one block of memory
    float *nx, *ny, *nz;      ///< without normals all three are one column of zeros
} stp_grid;

/// Builds a grid of points with positions and normals, 3 floats each; `normals` may be NULL.
STP_MUST_USE stp_result stp_grid_create(stp_context* context, const float* positions,
                                        const float* normals, uint32_t count, float cell,
                                        float offset, stp_grid* grid);
/// The same with offset 0, and the given cell size or the largest half, quarter, ... of it with
/// which buckets are not crowded, on average over the points.
STP_MUST_USE stp_result stp_grid_create_uncrowded(stp_context* context, const float* positions,
                                                  const float* normals, uint32_t count, float cell,
                                                  stp_grid* grid);
/// Builds a grid, with offset 0, of every stride-th point of another. Consecutive points are
/// neighbours in space: each region is thinned equally, and reading is fast. `index` refers to
/// the same arrays as in that grid.
STP_MUST_USE stp_result stp_grid_thin(stp_context* context, const stp_grid* from, uint32_t stride,
                                      float cell, stp_grid* grid);
void stp_grid_destroy(stp_context* context, stp_grid* grid);

static inline int32_t stp_grid_cell(const stp_grid* grid, float coordinate)
{
    float cell = (coordinate - grid->offset) * grid->inverse_cell;
    cell = cell < -1e9f ? -1e9f : cell > 1e9f ? 1e9f : cell;
    int32_t truncated = (int32_t)cell;
    return truncated - (cell < (float)truncated);
}

/// Cells are grouped in blocks of 4 x 4 x 4, so that consecutive buckets are mostly close in space.
static inline uint32_t stp_grid_bucket(const stp_grid* grid, int32_t x, int32_t y, int32_t z)
{
    uint32_t cx = (uint32_t)x, cy = (uint32_t)y, cz = (uint32_t)z;
    uint32_t hash = (cx >> 2) * 0x9E3779B1u ^ (cy >> 2) * 0x85EBCA77u ^ (cz >> 2) * 0xC2B2AE3Du;
    hash ^= hash >> 15;
    hash *= 0x2C1B3C6Du;
    hash ^= hash >> 13;
    return (hash << 6 | (cz & 3) << 4 | (cy & 3) << 2 | (cx & 3)) & grid->mask;
}

/// Lists the points along a Morton curve (Morton 1966), so that visits in this order find the data
/// of neighbours in the cache. `order` receives `count` indices.
STP_MUST_USE stp_result stp_sort_spatially(stp_context* context, const float* positions,
                                           uint32_t count, uint32_t* order);

// Finding the buckets of points. Every variant gives the same bits.

/// Coordinates with a stride in floats.
typedef struct stp_grid_points {
    const float *x, *y, *z;
    size_t stride;
} stp_grid_points;

typedef struct stp_grid_kernels {
    /// The buckets of the points [begin, end).
    void (*find_buckets)(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                         size_t end, uint32_t* buckets);
} stp_grid_kernels;

/// The kernels for this CPU.
const stp_grid_kernels* stp_grid_kernels_select(void);

extern const stp_grid_kernels stp_grid_kernels_portable;
extern const stp_grid_kernels stp_grid_kernels_vector;
