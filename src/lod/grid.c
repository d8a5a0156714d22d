// SPDX-License-Identifier: MIT
#include "lod/grid.h"

#include <string.h>

// A block may hold this many points on average before its reach is halved; exact orders stay far
// below.
#define MOST_IN_BLOCK 1000u
#define MOST_HALVINGS 32

static int32_t cell_of(float coordinate, float inverse_cell)
{
    float cell = coordinate * inverse_cell;
    cell = cell < -1e9f ? -1e9f : cell > 1e9f ? 1e9f : cell;
    int32_t truncated = (int32_t)cell;
    return truncated - (cell < (float)truncated);
}

static uint32_t bucket_of(const stp_grid* grid, int32_t x, int32_t y, int32_t z)
{
    uint32_t hash =
        (uint32_t)x * 0x9E3779B1u ^ (uint32_t)y * 0x85EBCA77u ^ (uint32_t)z * 0xC2B2AE3Du;
    hash ^= hash >> 15;
    hash *= 0x2C1B3C6Du;
    return (hash ^ hash >> 13) & grid->mask;
}

static uint32_t bucket_of_point(const stp_grid* grid, uint32_t point)
{
    const float* p = grid->positions + 3 * (size_t)point;
    return bucket_of(grid, cell_of(p[0], grid->inverse_cell), cell_of(p[1], grid->inverse_cell),
                     cell_of(p[2], grid->inverse_cell));
}

// Counts the points of each bucket; @return how many points share a bucket with a point, on average
static double count_points(stp_grid* grid)
{
    memset(grid->starts, 0, ((size_t)grid->mask + 2) * sizeof(uint32_t));
    for (uint32_t i = 0; i < grid->count; ++i) {
        grid->starts[bucket_of_point(grid, i)] += 1;
    }
    double pairs = 0.0;
    for (size_t bucket = 0; bucket <= grid->mask; ++bucket) {
        pairs += (double)grid->starts[bucket] * (double)grid->starts[bucket];
    }
    return pairs / (double)grid->count;
}

stp_result stp_grid_create(stp_context* context, const float* positions, const float* normals,
                           uint32_t count, float reach, stp_grid* grid)
{
    uint32_t buckets = 64;
    while (buckets < count && buckets < (1u << 30)) {
        buckets *= 2;
    }
    *grid =
        (stp_grid){.positions = positions, .normals = normals, .count = count, .mask = buckets - 1};
    grid->starts = STP_NEW_ARRAY(context, uint32_t, (size_t)buckets + 1);
    grid->items = STP_NEW_ARRAY(context, uint32_t, count);
    if (grid->starts == NULL || grid->items == NULL) {
        stp_grid_destroy(context, grid);
        return stp_fail_memory(context);
    }
    for (int halvings = 0;; ++halvings) {
        grid->reach = reach;
        grid->inverse_cell = 0.5f / reach;
        if (count_points(grid) <= MOST_IN_BLOCK / 8 || halvings == MOST_HALVINGS) {
            break;
        }
        reach *= 0.5f;
    }
    uint32_t end =
        0; // starts become ends, and sink back to starts while points are put in from the last
    for (size_t bucket = 0; bucket <= grid->mask; ++bucket) {
        end += grid->starts[bucket];
        grid->starts[bucket] = end;
    }
    grid->starts[(size_t)grid->mask + 1] = end;
    for (uint32_t i = count; i > 0; --i) {
        grid->items[--grid->starts[bucket_of_point(grid, i - 1)]] = i - 1;
    }
    return STP_OK;
}

void stp_grid_destroy(stp_context* context, stp_grid* grid)
{
    stp_free(context, grid->starts);
    stp_free(context, grid->items);
    grid->starts = grid->items = NULL;
}

static bool load_page(const stp_grid* grid, stp_grid_block* block)
{
    block->count = 0;
    while (block->range < block->range_count) {
        uint32_t range = block->range;
        while (block->begins[range] + block->offset < block->ends[range]) {
            if (block->count == STP_GRID_PAGE) {
                return true;
            }
            uint32_t point = grid->items[block->begins[range] + block->offset++];
            const float* p = grid->positions + 3 * (size_t)point;
            const float* n = grid->normals + 3 * (size_t)point;
            uint32_t at = block->count++;
            block->index[at] = point;
            block->x[at] = p[0];
            block->y[at] = p[1];
            block->z[at] = p[2];
            block->nx[at] = n[0];
            block->ny[at] = n[1];
            block->nz[at] = n[2];
        }
        block->range += 1;
        block->offset = 0;
    }
    return false;
}

bool stp_grid_load(const stp_grid* grid, stp_grid_block* block, const float place[3])
{
    int32_t cell[3];
    for (int axis = 0; axis < 3; ++axis) {
        cell[axis] = cell_of(place[axis] - grid->reach, grid->inverse_cell);
    }
    if (block->valid && memcmp(cell, block->cell, sizeof(cell)) == 0) {
        return false;
    }
    memcpy(block->cell, cell, sizeof(cell));
    uint32_t buckets[8];
    block->range_count = 0;
    for (int corner = 0; corner < 8; ++corner) {
        uint32_t bucket = bucket_of(grid, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                                    cell[2] + (corner >> 2));
        bool known = grid->starts[bucket] == grid->starts[bucket + 1];
        for (uint32_t i = 0; !known && i < block->range_count; ++i) {
            known = buckets[i] == bucket;
        }
        if (!known) {
            buckets[block->range_count] = bucket;
            block->begins[block->range_count] = grid->starts[bucket];
            block->ends[block->range_count] = grid->starts[bucket + 1];
            block->range_count += 1;
        }
    }
    block->range = block->offset = 0;
    bool more = load_page(grid, block);
    block->valid = !more;
    return more;
}

bool stp_grid_next(const stp_grid* grid, stp_grid_block* block)
{
    return load_page(grid, block);
}
