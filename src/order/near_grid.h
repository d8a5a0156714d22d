// SPDX-License-Identifier: MIT
//
// Nearest-neighbour search in a growing set whose points get ever closer to each other: a hash grid
// whose cells halve when they fill up. The points of a cell are stored together, eight to a block,
// so a cell costs one vector evaluation.
#pragma once

#include "base/core/context.h"

#include <assert.h>

enum { STP_BLOCK_SIZE = 8 };

typedef struct stp_near_grid_block {
    float x[STP_BLOCK_SIZE], y[STP_BLOCK_SIZE], z[STP_BLOCK_SIZE]; ///< unused lanes: infinity
    uint32_t count;
    uint32_t next; ///< next block of the same cell: its index + 1; 0: none
    uint32_t spare[6];
} stp_near_grid_block;

typedef struct stp_near_grid_slot {
    uint64_t cell;  ///< UINT64_MAX: empty
    uint32_t block; ///< first block of the cell
} stp_near_grid_slot;

typedef struct stp_near_grid {
    stp_context* context;
    float low[3];              ///< corner of the bounding box of all points and queries
    float cell_size, per_cell; ///< cell size and its inverse
    uint32_t limit;            ///< cells along the longest axis
    stp_near_grid_slot* slots;
    uint32_t slot_shift; ///< 64 - log2 of the number of slots
    uint32_t slot_mask;
    stp_near_grid_block* blocks;
    size_t block_capacity;
    uint32_t block_count, cell_count, point_count;
    stp_near_grid_block* previous; ///< scratch for rebuilding
    size_t former_capacity;
} stp_near_grid;

/// For points within `extent` of `low` along each axis.
STP_MUST_USE stp_result stp_near_grid_create(stp_context* context, stp_near_grid* grid,
                                             const float low[3], float extent);
void stp_near_grid_destroy(stp_near_grid* grid);
/// Adds a point. @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_near_grid_add(stp_near_grid* grid, float x, float y, float z);

/// Squared distances from `count` points (3 floats each) to the nearest point of the grid; infinity
/// if it is empty. Rounded like the distances of the tree. All variants give the same bits.
typedef void (*stp_near_grid_nearest)(const stp_near_grid* grid, const float* points,
                                      uint32_t count, float* squared);
void stp_near_grid_nearest_portable(const stp_near_grid* grid, const float* points, uint32_t count,
                                    float* squared);
void stp_near_grid_nearest_vector(const stp_near_grid* grid, const float* points, uint32_t count,
                                  float* squared);
stp_near_grid_nearest stp_near_grid_nearest_select(void);

static inline uint64_t stp_near_grid_cell(uint32_t x, uint32_t y, uint32_t z)
{
    return (uint64_t)x | (uint64_t)y << 21 | (uint64_t)z << 42;
}

/// The slot of a cell, or the empty slot where it would go.
static inline uint32_t stp_near_grid_find(const stp_near_grid* grid, uint64_t cell)
{
    assert(grid->cell_count <= grid->slot_mask && "an empty slot ends the search");
    uint32_t slot = (uint32_t)((cell * UINT64_C(0x9E3779B97F4A7C15)) >> grid->slot_shift);
    while (grid->slots[slot].cell != cell && grid->slots[slot].cell != UINT64_MAX) {
        slot = (slot + 1) & grid->slot_mask;
    }
    return slot;
}

static inline uint32_t stp_near_grid_coordinate(const stp_near_grid* grid, float value, int axis)
{
    assert(axis >= 0 && axis < 3 && grid->limit > 0);
    float at = (value - grid->low[axis]) * grid->per_cell;
    uint32_t whole = at > 0.0f ? (uint32_t)at : 0;
    return whole < grid->limit ? whole : grid->limit - 1;
}
