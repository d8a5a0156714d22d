// SPDX-License-Identifier: MIT
#include "order/near_grid.h"

#include "base/core/processor.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    FIRST_LIMIT = 4,      // initial cells per axis
    LAST_LIMIT = 1 << 20, // maximum cells per axis
    FULL = 4,             // average points per cell at which cells are halved
    FIRST_SLOTS_LOG2 = 10,
};

static stp_result set_slots(stp_near_grid* grid, uint32_t log2_count)
{
    assert(log2_count > 0 && log2_count <= 32);
    size_t count = (size_t)1 << log2_count;
    if (grid->slots == NULL || grid->slot_shift != 64 - log2_count) {
        stp_near_grid_slot* slots = STP_NEW_ARRAY(grid->context, stp_near_grid_slot, count);
        if (slots == NULL) {
            return stp_fail_memory(grid->context);
        }
        stp_free(grid->context, grid->slots);
        grid->slots = slots;
        grid->slot_shift = 64 - log2_count;
        grid->slot_mask = (uint32_t)count - 1;
    }
    memset(grid->slots, 0xFF, count * sizeof(grid->slots[0]));
    return STP_OK;
}

stp_result stp_near_grid_create(stp_context* context, stp_near_grid* grid, const float low[3],
                                float extent)
{
    *grid =
        (stp_near_grid){.context = context, .low = {low[0], low[1], low[2]}, .limit = FIRST_LIMIT};
    grid->cell_size = extent > 0.0f ? extent / FIRST_LIMIT : 1.0f;
    grid->per_cell = 1.0f / grid->cell_size;
    return set_slots(grid, FIRST_SLOTS_LOG2);
}

void stp_near_grid_destroy(stp_near_grid* grid)
{
    stp_free(grid->context, grid->slots);
    stp_free(grid->context, grid->blocks);
    stp_free(grid->context, grid->previous);
    *grid = (stp_near_grid){0};
}

static stp_result new_block(stp_near_grid* grid, uint32_t* index)
{
    if (!STP_MAKE_ROOM(grid->context, grid->blocks, grid->block_capacity,
                       (size_t)grid->block_count + 1)) {
        return stp_fail_memory(grid->context);
    }
    stp_near_grid_block* block = &grid->blocks[grid->block_count];
    for (int i = 0; i < STP_BLOCK_SIZE; ++i) {
        block->x[i] = block->y[i] = block->z[i] = INFINITY;
    }
    block->count = 0;
    block->next = 0;
    *index = grid->block_count++;
    return STP_OK;
}

static stp_result put(stp_near_grid* grid, float x, float y, float z)
{
    uint64_t cell = stp_near_grid_cell(stp_near_grid_coordinate(grid, x, 0),
                                       stp_near_grid_coordinate(grid, y, 1),
                                       stp_near_grid_coordinate(grid, z, 2));
    stp_near_grid_slot* slot = &grid->slots[stp_near_grid_find(grid, cell)];
    bool fresh = slot->cell == UINT64_MAX;
    if (fresh || grid->blocks[slot->block].count == STP_BLOCK_SIZE) {
        uint32_t index = 0;
        stp_result result = new_block(grid, &index);
        if (result != STP_OK) {
            return result;
        }
        grid->blocks[index].next = fresh ? 0 : slot->block + 1;
        grid->cell_count += fresh;
        *slot = (stp_near_grid_slot){cell, index};
    }
    stp_near_grid_block* block = &grid->blocks[slot->block];
    assert(slot->block < grid->block_count && block->count < STP_BLOCK_SIZE);
    block->x[block->count] = x;
    block->y[block->count] = y;
    block->z[block->count] = z;
    block->count += 1;
    return STP_OK;
}

// Rebuilds the grid with `limit` cells per axis and 2^`log2_count` slots.
static stp_result rebuild(stp_near_grid* grid, uint32_t limit, uint32_t log2_count)
{
    assert((limit & (limit - 1)) == 0 && limit >= grid->limit);
    stp_near_grid_block* blocks = grid->blocks;
    size_t capacity = grid->block_capacity;
    uint32_t count = grid->block_count;
    stp_result result = set_slots(grid, log2_count);
    if (result != STP_OK) {
        return result;
    }
    grid->blocks = grid->previous;
    grid->block_capacity = grid->former_capacity;
    grid->previous = blocks;
    grid->former_capacity = capacity;
    grid->block_count = grid->cell_count = 0;
    grid->cell_size *= (float)grid->limit / (float)limit; // both powers of two
    grid->per_cell = 1.0f / grid->cell_size;
    grid->limit = limit;
    for (uint32_t b = 0; b < count && result == STP_OK; ++b) {
        for (uint32_t i = 0; i < blocks[b].count && result == STP_OK; ++i) {
            result = put(grid, blocks[b].x[i], blocks[b].y[i], blocks[b].z[i]);
        }
    }
    return result;
}

stp_result stp_near_grid_add(stp_near_grid* grid, float x, float y, float z)
{
    stp_result result = put(grid, x, y, z);
    grid->point_count += 1;
    uint32_t log2_count = 64 - grid->slot_shift;
    if (result == STP_OK && grid->point_count > FULL * grid->cell_count &&
        grid->limit < LAST_LIMIT && grid->point_count >= 2 * FULL) {
        result = rebuild(grid, grid->limit * 2, log2_count);
    }
    if (result == STP_OK && grid->cell_count > grid->slot_mask / 4) {
        result = rebuild(grid, grid->limit, log2_count + 1);
    }
    return result;
}

stp_near_grid_nearest stp_near_grid_nearest_select(void)
{
    return STP_VARIANT_OF_TWO(stp_processor_detect(), stp_near_grid_nearest);
}
