// SPDX-License-Identifier: MIT
//
// Grid search, written over the names of a vector_*.h and compiled once per instruction set. The
// includer defines NEAREST, the name of the function.
#include "order/near_grid.h"

#include <assert.h>
#include <math.h>

enum {
    RINGS = 3,  // rings of cells searched around the query's before all points are
    BATCH = 16, // queries in flight
};

typedef struct grid_query {
    eight x, y, z;
    eight nearest; // squared, in each lane
} grid_query;

static inline void search_block_chain(const stp_near_grid* grid, uint32_t index, grid_query* q)
{
    for (uint32_t next = index + 1; next != 0; next = grid->blocks[next - 1].next) {
        assert(next <= grid->block_count);
        const stp_near_grid_block* block = &grid->blocks[next - 1];
        eight x = eight_sub(eight_load(block->x), q->x);
        eight y = eight_sub(eight_load(block->y), q->y);
        eight z = eight_sub(eight_load(block->z), q->z);
        eight squared = eight_add(eight_add(eight_mul(x, x), eight_mul(y, y)), eight_mul(z, z));
        q->nearest = eight_min(q->nearest, squared);
    }
}

static inline void search_cell(const stp_near_grid* grid, uint32_t x, uint32_t y, uint32_t z,
                               grid_query* q)
{
    const stp_near_grid_slot* slot =
        &grid->slots[stp_near_grid_find(grid, stp_near_grid_cell(x, y, z))];
    if (slot->cell != UINT64_MAX) {
        search_block_chain(grid, slot->block, q);
    }
}

// Inclusive range of cells along one axis, inside the grid.
typedef struct cell_range {
    int32_t low, high;
} cell_range;

static inline cell_range clip(const stp_near_grid* grid, int32_t low, int32_t high)
{
    int32_t last = (int32_t)grid->limit - 1;
    assert(low <= last && high >= 0 && "the range meets the grid");
    return (cell_range){low < 0 ? 0 : low, high > last ? last : high};
}

// Searches the shell of cells at distance `ring` from the given one.
static void search_ring(const stp_near_grid* grid, const int32_t at[3], int32_t ring, grid_query* q)
{
    cell_range x = clip(grid, at[0] - ring, at[0] + ring),
               y = clip(grid, at[1] - ring, at[1] + ring),
               z = clip(grid, at[2] - ring, at[2] + ring);
    for (int32_t k = z.low; k <= z.high; ++k) {
        for (int32_t j = y.low; j <= y.high; ++j) {
            bool whole =
                k == at[2] - ring || k == at[2] + ring || j == at[1] - ring || j == at[1] + ring;
            for (int32_t i = x.low; i <= x.high; ++i) {
                if (whole || i == at[0] - ring || i == at[0] + ring) {
                    search_cell(grid, (uint32_t)i, (uint32_t)j, (uint32_t)k, q);
                }
            }
        }
    }
}

// The query's cell and its neighbours on the nearer sides: together they cover half a cell around
// the query.
static inline void octant(const stp_near_grid* grid, const float* point, int32_t at[3],
                          cell_range range[3])
{
    for (int axis = 0; axis < 3; ++axis) {
        at[axis] = (int32_t)stp_near_grid_coordinate(grid, point[axis], axis);
        float within = (point[axis] - grid->low[axis]) * grid->per_cell - (float)at[axis];
        range[axis] =
            within < 0.5f ? clip(grid, at[axis] - 1, at[axis]) : clip(grid, at[axis], at[axis] + 1);
    }
}

static float search(const stp_near_grid* grid, const float* point)
{
    grid_query q = {eight_set(point[0]), eight_set(point[1]), eight_set(point[2]),
                    eight_set(INFINITY)};
    int32_t at[3];
    cell_range range[3];
    octant(grid, point, at, range);
    for (int32_t k = range[2].low; k <= range[2].high; ++k) {
        for (int32_t j = range[1].low; j <= range[1].high; ++j) {
            for (int32_t i = range[0].low; i <= range[0].high; ++i) {
                search_cell(grid, (uint32_t)i, (uint32_t)j, (uint32_t)k, &q);
            }
        }
    }
    float nearest = eight_lowest(q.nearest);
    float searched = grid->cell_size * 0.499f; // a little less than half a cell, for rounding
    for (int32_t ring = 1; ring <= RINGS && !(nearest <= searched * searched); ++ring) {
        search_ring(grid, at, ring, &q);
        nearest = eight_lowest(q.nearest);
        searched = grid->cell_size * ((float)ring - 0.001f * (float)ring);
    }
    if (!(nearest <= searched * searched)) {
        for (uint32_t block = 0; block < grid->block_count; ++block) {
            eight x = eight_sub(eight_load(grid->blocks[block].x), q.x);
            eight y = eight_sub(eight_load(grid->blocks[block].y), q.y);
            eight z = eight_sub(eight_load(grid->blocks[block].z), q.z);
            eight squared = eight_add(eight_add(eight_mul(x, x), eight_mul(y, y)), eight_mul(z, z));
            q.nearest = eight_min(q.nearest, squared);
        }
        nearest = eight_lowest(q.nearest);
    }
    return nearest;
}

// Prefetches the slots of the cells that a search begins with.
static void prefetch_cells(const stp_near_grid* grid, const float* point)
{
    int32_t at[3];
    cell_range range[3];
    octant(grid, point, at, range);
    for (int corner = 0; corner < 8; ++corner) {
        uint32_t x = (uint32_t)((corner & 1) != 0 ? range[0].high : range[0].low);
        uint32_t y = (uint32_t)((corner & 2) != 0 ? range[1].high : range[1].low);
        uint32_t z = (uint32_t)((corner & 4) != 0 ? range[2].high : range[2].low);
        uint64_t hash = stp_near_grid_cell(x, y, z) * UINT64_C(0x9E3779B97F4A7C15);
        __builtin_prefetch(&grid->slots[hash >> grid->slot_shift]);
    }
}

void NEAREST(const stp_near_grid* grid, const float* points, uint32_t count, float* squared)
{
    for (uint32_t begin = 0; begin < count; begin += BATCH) {
        uint32_t end = count - begin < BATCH ? count : begin + BATCH;
        for (uint32_t i = begin; i < end; ++i) {
            prefetch_cells(grid, points + 3 * (size_t)i);
        }
        for (uint32_t i = begin; i < end; ++i) {
            squared[i] = search(grid, points + 3 * (size_t)i);
        }
    }
}
