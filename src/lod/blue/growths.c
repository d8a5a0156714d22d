// SPDX-License-Identifier: MIT
#include "lod/blue/growths.h"

#include "base/core/processor.h"
#include "lod/blue/growths_kernels.h"
#include "lod/grid.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum {
    LEVELS = 3,         ///< grids, each with cells twice as wide
    FINE_POINTS = 24,   ///< points of a bucket that are compared: the first of the order
    COARSE_POINTS = 32, ///< the same for wide gaps
    VOLUME =
        6, ///< from so many steep neighbours on, wide gaps are those of leaves, not of a surface
    OUTSTANDING = 2,         ///< how far a growth may be above the median around it
    AROUND = 3,              ///< from so many other points on, a wider cell has a median
    UNLIMITED = STP_GROWTHS, ///< in place of a growth that is still to be limited
    GRAIN = 1024             ///< buckets
};

#define FINE_CELL 2.5f    // side of a cell, in spacings
#define FIRST 0.6f        // neighbours within so many sides of a cell cut first
#define STEEP_WITHIN 0.8f // where steep neighbours count, in sides of a cell
#define CLOSED 3.0f       // a cell that reaches less far there is closed, in covered distances
#define HOLE 2.0f         // how far it then counts
#define ENCLOSED 5.0f     // a cell that reaches less far to all sides, in covered distances
#define TOLERANCE 1.06f   // radii that are this much too small are good enough

_Static_assert(27 * COARSE_POINTS + STP_GROWTH_LANES <= STP_AROUND_MAX, "neighbours fit");

static const float factors[STP_GROWTHS] = {0.125f,    0.176777f, 0.25f,     0.353553f, 0.5f,
                                           0.707107f, 1.0f,      1.414214f, 2.0f,      2.828427f,
                                           4.0f,      5.656854f, 8.0f};

float stp_growth_factor(uint32_t growth)
{
    assert(growth < STP_GROWTHS);
    return factors[growth];
}

const stp_growth_kernels* stp_growth_kernels_select(void)
{
    return STP_VARIANT_OF_TWO(stp_processor_detect(), &stp_growth_kernels);
}

typedef struct gap_search {
    const stp_growth_desc* desc;
    const stp_growth_kernels* kernels;
    stp_grid grids[LEVELS]; ///< of all points, then of sparse ones
    stp_cell_limits limits;
    float thresholds[STP_GROWTHS]; ///< how far each growth is enough
    uint8_t* found;                ///< growth of each point
    uint8_t* growths;              ///< the same, and not far above those around it
} gap_search;

/// The cells of a grid around a place, and the points in them.
typedef struct surroundings {
    const stp_grid* grid;
    uint32_t limit;  ///< points of a bucket that count
    int32_t cell[3]; ///< the middle one
    bool known;      ///< whether there is one
    stp_around around;
} surroundings;

/// Copies points of a grid to the end of a list, in whole vectors.
static void copy_points(const stp_grid* grid, uint32_t begin, uint32_t end, stp_around* to)
{
    assert(begin <= end && to->count + (end - begin) + STP_GROWTH_LANES <= STP_AROUND_MAX);
    const float *x = grid->x, *y = grid->y, *z = grid->z;
    uint32_t next = to->count;
    for (uint32_t at = begin; at < end; at += STP_GROWTH_LANES, next += STP_GROWTH_LANES) {
        memcpy(to->x + next, x + at, STP_GROWTH_LANES * sizeof(float));
        memcpy(to->y + next, y + at, STP_GROWTH_LANES * sizeof(float));
        memcpy(to->z + next, z + at, STP_GROWTH_LANES * sizeof(float));
    }
    to->count += end - begin;
}

/// Copies the first points of each of consecutive buckets.
static void copy_buckets(surroundings* s, uint32_t bucket, uint32_t count)
{
    const uint32_t* starts = s->grid->starts + bucket;
    if (starts[count] - starts[0] <= s->limit) { // mostly
        copy_points(s->grid, starts[0], starts[count], &s->around);
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t points = starts[i + 1] - starts[i];
        points = points < s->limit ? points : s->limit;
        copy_points(s->grid, starts[i], starts[i] + points, &s->around);
    }
}

/// Lists the points of the 27 cells around a place. Cells of a row that are of one block are
/// consecutive buckets.
static void list_around(surroundings* s, stp_vec3 place)
{
    const stp_grid* grid = s->grid;
    int32_t x = stp_grid_cell(grid, place.x), y = stp_grid_cell(grid, place.y),
            z = stp_grid_cell(grid, place.z);
    if (s->known && s->cell[0] == x && s->cell[1] == y && s->cell[2] == z) {
        return; // mostly
    }
    s->known = true;
    s->cell[0] = x, s->cell[1] = y, s->cell[2] = z;
    stp_around* to = &s->around;
    to->count = 0;
    int32_t split = ((x - 1) | 3) + 1; // where the next block begins
    uint32_t first = split > x + 1 ? 3 : (uint32_t)(split - (x - 1));
    for (int i = 0; i < 9; ++i) {
        int32_t row = y + i % 3 - 1, layer = z + i / 3 - 1;
        copy_buckets(s, stp_grid_bucket(grid, x - 1, row, layer), first);
        if (first < 3) {
            copy_buckets(s, stp_grid_bucket(grid, split, row, layer), 3 - first);
        }
    }
    for (; to->count % STP_GROWTH_LANES != 0; ++to->count) {
        to->x[to->count] = to->y[to->count] = to->z[to->count] = INFINITY;
    }
}

static void begin_surroundings(surroundings* s, const stp_grid* grid, uint32_t limit)
{
    s->grid = grid;
    s->limit = limit;
    s->known = false;
}

static void begin_cell(const stp_growth_desc* d, uint32_t index, stp_plane_cell* cell)
{
    const float *p = d->positions + 3 * (size_t)index, *n = d->normals + 3 * (size_t)index;
    *cell = (stp_plane_cell){
        .point = {p[0], p[1], p[2]}, .normal = {n[0], n[1], n[2]}, .beyond = INFINITY};
    stp_vec3 axis =
        fabsf(n[0]) < 0.6f ? (stp_vec3){1.0f, 0.0f, 0.0f} : (stp_vec3){0.0f, 1.0f, 0.0f};
    cell->across = stp_normalize(stp_cross(cell->normal, axis));
    cell->along = stp_cross(cell->normal, cell->across);
}

static uint8_t growth_for(const gap_search* s, float reach)
{
    uint32_t growth = 0;
    for (int k = 0; k < STP_GROWTHS - 1; ++k) {
        growth += s->thresholds[k] < reach ? 1 : 0;
    }
    return (uint8_t)(growth < STP_GROWTH_PLAIN && !s->desc->smaller ? STP_GROWTH_PLAIN : growth);
}

/// Cuts the cell of a point by the points around, in ever wider cells of grids until it is closed.
static void find_cell(const gap_search* s, surroundings levels[LEVELS], stp_plane_cell* cell)
{
    float seen = 0.0f; // flat neighbours up to here have cut, squared
    for (int i = 0; i < LEVELS; ++i) {
        surroundings* level = &levels[i];
        list_around(level, cell->point);
        float side = level->grid->cell, first = i == 0 ? FIRST * side : side;
        float steep = i == 0 ? STEEP_WITHIN * side : 0.0f;
        s->kernels->cut(&level->around, seen, first * first, steep * steep, cell);
        if (cell->least * side >= 2.0f || cell->steep >= VOLUME) {
            break;
        }
        seen = 0.5f * side * side; // flat ones are up to sqrt(2) times as far away
    }
}

static void search_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    const stp_grid* grid = &s->grids[0];
    surroundings levels[LEVELS];
    for (int i = 0; i < LEVELS; ++i) {
        begin_surroundings(&levels[i], &s->grids[i], i == 0 ? FINE_POINTS : COARSE_POINTS);
    }
    for (uint32_t at = grid->starts[begin]; at < grid->starts[end]; ++at) {
        stp_plane_cell cell;
        begin_cell(s->desc, grid->index[at], &cell);
        find_cell(s, levels, &cell);
        s->found[grid->index[at]] = growth_for(s, s->kernels->reach(&s->limits, &cell));
    }
}

static bool is_in_cell(const stp_grid* grid, uint32_t at, const int32_t cell[3])
{
    return stp_grid_cell(grid, grid->x[at]) == cell[0] &&
           stp_grid_cell(grid, grid->y[at]) == cell[1] &&
           stp_grid_cell(grid, grid->z[at]) == cell[2];
}

/// The growths of the other points in the cell of a grid that holds a point.
typedef struct cell_census {
    int32_t cell[3];
    uint32_t others;
    uint32_t at_most[STP_GROWTHS]; ///< points with a growth of at most each index, with its own
} cell_census;

static void take_census(const gap_search* s, const stp_grid* grid, uint32_t index,
                        cell_census* census)
{
    const float* p = s->desc->positions + 3 * (size_t)index;
    *census = (cell_census){
        .cell = {stp_grid_cell(grid, p[0]), stp_grid_cell(grid, p[1]), stp_grid_cell(grid, p[2])}};
    uint32_t bucket = stp_grid_bucket(grid, census->cell[0], census->cell[1], census->cell[2]);
    for (uint32_t at = grid->starts[bucket]; at < grid->starts[bucket + 1]; ++at) {
        if (is_in_cell(grid, at, census->cell)) { // the bucket may hold other cells
            census->at_most[s->found[grid->index[at]]] += 1;
        }
    }
    for (uint32_t k = 1; k < STP_GROWTHS; ++k) {
        census->at_most[k] += census->at_most[k - 1];
    }
    census->others = census->at_most[STP_GROWTHS - 1] - (index < grid->count ? 1 : 0);
}

/// A growth, or the largest smaller one that is at most OUTSTANDING above the median of the others.
static uint8_t limit_growth(uint8_t growth, const cell_census* census)
{
    while (growth > STP_GROWTH_PLAIN &&
           2 * census->at_most[growth - OUTSTANDING - 1] >= census->others) {
        growth -= 1;
    }
    return growth;
}

/// Limits the growths of points [at, end) of a bucket of the finest grid that are in the cell of the
/// first and still to be limited.
static void limit_cell(const gap_search* s, uint32_t at, uint32_t end)
{
    const stp_grid* grid = &s->grids[0];
    cell_census around;
    take_census(s, grid, grid->index[at], &around);
    bool lonely = around.others == 0;
    if (lonely) {
        cell_census wide;
        take_census(s, &s->grids[1], grid->index[at], &wide);
        around = wide.others >= AROUND ? wide : around;
        end = at + 1;
    }
    for (; at < end; ++at) {
        uint32_t index = grid->index[at];
        if (s->growths[index] == UNLIMITED && (lonely || is_in_cell(grid, at, around.cell))) {
            s->growths[index] = limit_growth(s->found[index], &around);
        }
    }
}

/// Limits growths that are far above those around them, of points in the air, whose neighbours in
/// the plane are not of their surface: to OUTSTANDING above the median of the other points of their
/// cell of the finest grid. A point alone there takes the cell of the next grid; with fewer than
/// AROUND others there, it has STP_GROWTH_PLAIN.
static void limit_buckets(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    const stp_grid* grid = &s->grids[0];
    for (size_t bucket = begin; bucket < end; ++bucket) {
        uint32_t first = grid->starts[bucket], last = grid->starts[bucket + 1];
        for (uint32_t at = first; at < last; ++at) {
            uint8_t growth = s->found[grid->index[at]];
            s->growths[grid->index[at]] = growth > STP_GROWTH_PLAIN ? UNLIMITED : growth;
        }
        for (uint32_t at = first; at < last; ++at) {
            if (s->growths[grid->index[at]] == UNLIMITED) {
                limit_cell(s, at, last);
            }
        }
    }
}

static gap_search make_search(const stp_growth_desc* desc, uint8_t* growths)
{
    float plain = desc->covered + desc->radius;
    gap_search s = {.desc = desc,
                    .kernels = stp_growth_kernels_select(),
                    .limits = {.plain = plain,
                               .closed = 1.0f / (CLOSED * plain),
                               .hole = HOLE * plain,
                               .enclosed = 1.0f / (ENCLOSED * plain),
                               .most = desc->covered + desc->radius * factors[STP_GROWTHS - 1]},
                    .growths = growths};
    for (uint32_t i = 0; i < STP_GROWTHS; ++i) {
        s.thresholds[i] = (desc->covered + desc->radius * factors[i]) * TOLERANCE;
    }
    return s;
}

stp_result stp_growths_find(stp_context* context, const stp_growth_desc* desc, uint8_t* growths)
{
    assert(desc->spacing > 0.0f && desc->radius > 0.0f && desc->sparse_count <= desc->count);
    gap_search s = make_search(desc, growths);
    s.found = STP_NEW_ARRAY(context, uint8_t, desc->count);
    stp_result result = s.found == NULL ? stp_fail_memory(context) : STP_OK;
    float side = FINE_CELL * desc->spacing;
    for (int i = 0; i < LEVELS && result == STP_OK; ++i, side *= 2.0f) {
        result =
            stp_grid_create(context, desc->positions, NULL,
                            i == 0 ? desc->count : desc->sparse_count, side, 0.0f, &s.grids[i]);
    }
    if (result == STP_OK) {
        stp_parallel_for(context, (size_t)s.grids[0].mask + 1, GRAIN, search_buckets, &s);
        stp_parallel_for(context, (size_t)s.grids[0].mask + 1, GRAIN, limit_buckets, &s);
    }
    stp_free(context, s.found);
    for (int i = 0; i < LEVELS; ++i) {
        stp_grid_destroy(context, &s.grids[i]);
    }
    return result;
}
