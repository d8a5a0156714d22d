// SPDX-License-Identifier: MIT
#include "lod/grid.h"

#include "base/core/processor.h"

#include <assert.h>
#include <math.h>
#include <string.h>

// A bucket may hold this many points, on average over the points; exact orders stay far below.
#define MAX_IN_BUCKET 200.0
#define MAX_HALVINGS 32
#define MIN_CELL 0x1p-100f // its inverse is a float
#define GRAIN 32768
#define AHEAD 24 // points to prefetch ahead

typedef struct filling {
    stp_grid* grid;
    const stp_grid_kernels* kernels;
    stp_grid_points points; ///< all, or every stride-th
    const float* positions; ///< 3 each
    const float* normals;   ///< the same, or NULL
    const stp_grid* from;   ///< grid whose columns hold the points; NULL: the arrays above
    uint32_t stride;
    uint32_t* buckets; ///< bucket of each point
} filling;

static void find_buckets_portable(const stp_grid* grid, const stp_grid_points* points, size_t begin,
                                  size_t end, uint32_t* buckets)
{
    assert(begin <= end && points->stride > 0);
    for (size_t i = begin; i < end; ++i) {
        size_t at = i * points->stride;
        buckets[i] =
            stp_grid_bucket(grid, stp_grid_cell(grid, points->x[at]),
                            stp_grid_cell(grid, points->y[at]), stp_grid_cell(grid, points->z[at]));
    }
}

const stp_grid_kernels stp_grid_kernels_portable = {find_buckets_portable};

const stp_grid_kernels* stp_grid_kernels_select(void)
{
    return STP_VARIANT_OF_TWO(stp_processor_detect(), &stp_grid_kernels);
}

static void find_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const filling* f = user;
    f->kernels->find_buckets(f->grid, &f->points, begin, end, f->buckets);
}

static void fill_positions(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const filling* f = user;
    stp_grid* grid = f->grid;
    for (size_t at = begin; at < end; ++at) {
        if (at + AHEAD < end) {
            __builtin_prefetch(f->positions + 3 * (size_t)grid->index[at + AHEAD]);
        }
        const float* p = f->positions + 3 * (size_t)grid->index[at];
        grid->x[at] = p[0];
        grid->y[at] = p[1];
        grid->z[at] = p[2];
    }
}

static void fill_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const filling* f = user;
    stp_grid* grid = f->grid;
    for (size_t at = begin; at < end; ++at) {
        if (at + AHEAD < end) {
            __builtin_prefetch(f->positions + 3 * (size_t)grid->index[at + AHEAD]);
            __builtin_prefetch(f->normals + 3 * (size_t)grid->index[at + AHEAD]);
        }
        const float* p = f->positions + 3 * (size_t)grid->index[at];
        const float* n = f->normals + 3 * (size_t)grid->index[at];
        grid->x[at] = p[0];
        grid->y[at] = p[1];
        grid->z[at] = p[2];
        grid->nx[at] = n[0];
        grid->ny[at] = n[1];
        grid->nz[at] = n[2];
    }
}

static bool has_normals(const stp_grid* grid)
{
    return grid->ny != grid->nx;
}

static void copy_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const filling* f = user;
    const stp_grid* from = f->from;
    stp_grid* grid = f->grid;
    bool normals = has_normals(grid);
    for (size_t at = begin; at < end; ++at) {
        uint32_t i = grid->index[at];
        assert(i < from->count);
        grid->index[at] = from->index[i];
        grid->x[at] = from->x[i];
        grid->y[at] = from->y[i];
        grid->z[at] = from->z[i];
        if (normals) {
            grid->nx[at] = from->nx[i];
            grid->ny[at] = from->ny[i];
            grid->nz[at] = from->nz[i];
        }
    }
}

static uint32_t bucket_mask(uint32_t count)
{
    uint32_t buckets = 64;
    while (buckets < count && buckets < (1u << 30)) {
        buckets *= 2;
    }
    assert((buckets & (buckets - 1)) == 0 && "the mask selects lower bits of a hash");
    return buckets - 1;
}

static bool allocate(stp_context* context, stp_grid* grid, bool normals)
{
    size_t stride = ((size_t)grid->count / STP_GRID_LANES + 2) * STP_GRID_LANES;
    int count = normals ? 6 : 4;
    grid->starts = STP_NEW_ARRAY(context, uint32_t, (size_t)grid->mask + 2);
    grid->index = STP_NEW_ARRAY(context, uint32_t, stride);
    size_t floats = stride * (size_t)count;
    float* columns = STP_NEW_ARRAY(context, float, floats);
    grid->x = columns;
    if (grid->starts == NULL || grid->index == NULL || columns == NULL) {
        return false;
    }
    grid->y = columns + stride;
    grid->z = columns + 2 * stride;
    grid->nx = columns + 3 * stride;
    grid->ny = normals ? columns + 4 * stride : grid->nx;
    grid->nz = normals ? columns + 5 * stride : grid->nx;
    for (int i = 0; i < count; ++i) { // values beyond the end are read, but never used
        size_t filled = i < 3 || normals ? grid->count : 0;
        memset(columns + (size_t)i * stride + filled, 0, (stride - filled) * sizeof(float));
    }
    memset(grid->index + grid->count, 0, (stride - grid->count) * sizeof(uint32_t));
    return true;
}

// Counts points by bucket. @return the sum of squares
static double count_points(stp_context* context, filling* f)
{
    stp_grid* grid = f->grid;
    stp_parallel_for(context, grid->count, GRAIN, find_buckets, f);
    memset(grid->starts, 0, ((size_t)grid->mask + 2) * sizeof(grid->starts[0]));
    uint64_t before = 0; // pairs of points that share a bucket
    for (uint32_t i = 0; i < grid->count; ++i) {
        before += grid->starts[f->buckets[i]]++;
    }
    return 2.0 * (double)before + grid->count;
}

// Places the points. `starts` begin as ends, and become starts as points are inserted from the
// last.
static void place_points(stp_context* context, filling* f)
{
    stp_grid* grid = f->grid;
    uint32_t end = 0;
    for (size_t bucket = 0; bucket <= grid->mask; ++bucket) {
        end += grid->starts[bucket];
        grid->starts[bucket] = end;
    }
    assert(end == grid->count && "each point is in a bucket");
    grid->starts[(size_t)grid->mask + 1] = end;
    for (uint32_t i = grid->count; i > 0; --i) {
        grid->index[--grid->starts[f->buckets[i - 1]]] = (i - 1) * f->stride;
    }
    assert(grid->starts[0] == 0 && "all ends became starts");
    stp_job fill = f->normals != NULL ? fill_columns : fill_positions;
    stp_parallel_for(context, grid->count, GRAIN, f->from != NULL ? copy_columns : fill, f);
}

static stp_result fill_grid(stp_context* context, filling* f, uint32_t count, float cell,
                            float offset, double crowd)
{
    stp_grid* grid = f->grid;
    assert(f->stride > 0);
    cell = cell > MIN_CELL ? cell : MIN_CELL;
    count = count / f->stride + (count % f->stride != 0);
    *grid = (stp_grid){.count = count,
                       .cell = cell,
                       .inverse_cell = 1.0f / cell,
                       .offset = offset,
                       .mask = bucket_mask(count)};
    f->kernels = stp_grid_kernels_select();
    f->buckets = STP_NEW_ARRAY(context, uint32_t, count);
    bool normals = f->from != NULL ? has_normals(f->from) : f->normals != NULL;
    if (f->buckets == NULL || !allocate(context, grid, normals)) {
        stp_free(context, f->buckets);
        stp_grid_destroy(context, grid);
        return stp_fail_memory(context);
    }
    for (int i = 0; count_points(context, f) > crowd * (double)count && i < MAX_HALVINGS &&
                    grid->cell > MIN_CELL;
         ++i) {
        grid->cell *= 0.5f;
        grid->inverse_cell = 1.0f / grid->cell;
    }
    place_points(context, f);
    assert(grid->cell >= 0.5f * MIN_CELL && "its inverse is finite");
    stp_free(context, f->buckets);
    return STP_OK;
}

static filling fill_from_triples(stp_grid* grid, const float* positions, const float* normals)
{
    return (filling){.grid = grid,
                     .points = {positions, positions + 1, positions + 2, 3},
                     .positions = positions,
                     .normals = normals,
                     .stride = 1};
}

stp_result stp_grid_create(stp_context* context, const float* positions, const float* normals,
                           uint32_t count, float cell, float offset, stp_grid* grid)
{
    filling f = fill_from_triples(grid, positions, normals);
    return fill_grid(context, &f, count, cell, offset, (double)INFINITY);
}

stp_result stp_grid_create_uncrowded(stp_context* context, const float* positions,
                                     const float* normals, uint32_t count, float cell,
                                     stp_grid* grid)
{
    filling f = fill_from_triples(grid, positions, normals);
    return fill_grid(context, &f, count, cell, 0.0f, MAX_IN_BUCKET);
}

stp_result stp_grid_thin(stp_context* context, const stp_grid* from, uint32_t stride, float cell,
                         stp_grid* grid)
{
    assert(grid != from && "the points are copied from it");
    filling f = {.grid = grid,
                 .points = {from->x, from->y, from->z, stride},
                 .from = from,
                 .stride = stride};
    return fill_grid(context, &f, from->count, cell, 0.0f, (double)INFINITY);
}

void stp_grid_destroy(stp_context* context, stp_grid* grid)
{
    stp_free(context, grid->starts);
    stp_free(context, grid->index);
    stp_free(context, grid->x);
    *grid = (stp_grid){0};
}
