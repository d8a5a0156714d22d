// SPDX-License-Identifier: MIT
//
// Points in the buckets of a hashed grid. A query takes the eight cells around a place: with cells
// twice as wide as the reach of the query, they hold every point within reach.
//
//        +-----+-----+      x: the query; all points within reach (o) lie in its block of 2 x 2 (x
//        2) cells. |    o|o    |      Cells that share a bucket by chance only add points that are
//        too far away.
//        +----ox-----+
//        |     |     |
//        +-----+-----+
#pragma once

#include "base/context.h"

enum { STP_GRID_PAGE = 256 };

typedef struct stp_grid {
    const float* positions; ///< 3 a point; not owned
    const float* normals;   ///< 3 a point; not owned
    uint32_t count;
    float reach; ///< half a cell: how far a query sees
    float inverse_cell;
    uint32_t mask;    ///< number of buckets - 1
    uint32_t* starts; ///< of each bucket in `items`, and the end
    uint32_t* items;  ///< points by bucket, ascending within each
} stp_grid;

/// Builds a grid for queries of `reach` (above 0). A reach that would put very many points into
/// each block is halved until it does not: queries then see less far (`reach` of the result).
STP_MUST_USE stp_result stp_grid_create(stp_context* context, const float* positions,
                                        const float* normals, uint32_t count, float reach,
                                        stp_grid* grid);
void stp_grid_destroy(stp_context* context, stp_grid* grid);

/// The points of one block, copied side by side, page by page where there are many.
typedef struct stp_grid_block {
    int32_t cell[3];
    bool valid;
    uint32_t range_count, range, offset; ///< buckets of the block; where the next page starts
    uint32_t begins[8], ends[8];
    uint32_t count; ///< points in this page
    uint32_t index[STP_GRID_PAGE];
    float x[STP_GRID_PAGE], y[STP_GRID_PAGE], z[STP_GRID_PAGE];
    float nx[STP_GRID_PAGE], ny[STP_GRID_PAGE], nz[STP_GRID_PAGE];
} stp_grid_block;

/// Loads the block around a place, or keeps it where it is the one loaded. Only its first page is
/// loaded;
/// @return whether there are more
bool stp_grid_load(const stp_grid* grid, stp_grid_block* block, const float place[3]);
/// Loads the next page; @return whether there are more. The block then has to be loaded anew.
bool stp_grid_next(const stp_grid* grid, stp_grid_block* block);
