// SPDX-License-Identifier: MIT
#include "base/math/f32x8.h"
#include "lod/grid.h"

#include <assert.h>

enum { LANES = 8 };

// stp_grid_cell of eight coordinates.
static inline i32x8 find_cells(const stp_grid* grid, f32x8 coordinates)
{
    f32x8 cell = f32x8_sub(coordinates, f32x8_set(grid->offset));
    cell = f32x8_mul(cell, f32x8_set(grid->inverse_cell));
    cell = f32x8_min(f32x8_max(cell, f32x8_set(-1e9f)), f32x8_set(1e9f));
    return f32x8_truncate(f32x8_floor(cell));
}

static inline i32x8 multiply(i32x8 a, uint32_t b)
{
    return i32x8_mul(a, i32x8_set((int)b));
}

// The lower two bits of eight cells, shifted.
static inline i32x8 within_block(i32x8 cell, int shift)
{
    return i32x8_left(i32x8_and(cell, i32x8_set(3)), shift);
}

// stp_grid_bucket of eight cells.
static inline i32x8 hash_cells(const stp_grid* grid, i32x8 x, i32x8 y, i32x8 z)
{
    assert(grid->mask >= 63 && (grid->mask & (grid->mask + 1)) == 0);
    i32x8 hash = multiply(i32x8_right(x, 2), 0x9E3779B1u);
    hash = i32x8_xor(hash, multiply(i32x8_right(y, 2), 0x85EBCA77u));
    hash = i32x8_xor(hash, multiply(i32x8_right(z, 2), 0xC2B2AE3Du));
    hash = i32x8_xor(hash, i32x8_right(hash, 15));
    hash = multiply(hash, 0x2C1B3C6Du);
    hash = i32x8_xor(hash, i32x8_right(hash, 13));
    i32x8 within = i32x8_or(within_block(z, 4), within_block(y, 2));
    within = i32x8_or(within, within_block(x, 0));
    hash = i32x8_or(i32x8_left(hash, 6), within);
    return i32x8_and(hash, i32x8_set((int)grid->mask));
}

static void find_buckets(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                         size_t end, uint32_t* buckets)
{
    assert(begin <= end && points->stride > 0);
    bool triples = points->stride == 3 && points->y == points->x + 1 && points->z == points->x + 2;
    size_t i = begin;
    for (; end - i >= LANES; i += LANES) {
        size_t at = i * points->stride;
        f32x8 x, y, z;
        if (triples) {
            f32x8_load_triples(points->x + at, &x, &y, &z);
        } else {
            x = f32x8_load_apart(points->x + at, points->stride);
            y = f32x8_load_apart(points->y + at, points->stride);
            z = f32x8_load_apart(points->z + at, points->stride);
        }
        i32x8 bucket =
            hash_cells(grid, find_cells(grid, x), find_cells(grid, y), find_cells(grid, z));
        i32x8_store((int32_t*)buckets + i, bucket);
    }
    assert(end - i < LANES && "fewer points than lanes are left");
    stp_grid_kernels_portable.find_buckets(grid, points, i, end, buckets);
}

const stp_grid_kernels stp_grid_kernels_vector = {find_buckets};
