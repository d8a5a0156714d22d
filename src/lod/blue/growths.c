// SPDX-License-Identifier: MIT
#include "lod/blue/growths.h"

#include "base/math/math.h"
#include "lod/grid.h"

#include <assert.h>
#include <math.h>

enum {
    DIRECTIONS = 16,
    FINE_POINTS = 8,    ///< points of a bucket that are compared: the first of the order
    COARSE_POINTS = 24, ///< the same for wide gaps
    VOLUME =
        6, ///< from so many steep neighbours on, wide gaps are those of leaves, not of a surface
    OUTSTANDING = 2, ///< how far a growth may be above the median around it
    GRAIN = 512
};

#define FINE_CELL 1.5f   // side of a cell, in spacings
#define COARSE_CELL 8.0f // the same for wide gaps
#define ONE_SIDED 1.3f   // how much farther a cell may reach than on its opposite side
#define ENCLOSED 5.0f    // a cell that reaches less far to all sides, in covered distances
#define INNER_SIDED 2.0f // how much farther it may reach than on its opposite side
#define CLOSED 3.0f      // a cell that reaches less far there is closed, in covered distances
#define HOLE 2.0f        // how far it then counts
#define BETWEEN 1.05f    // corners of a cell may lie between two directions
#define TOLERANCE 1.06f  // radii that are this much too small are good enough
#define STEEP 1.0f // neighbours may lie this far from the plane, relative to their distance in it

static const float factors[STP_GROWTHS] = {0.125f,    0.176777f, 0.25f,     0.353553f, 0.5f,
                                           0.707107f, 1.0f,      1.414214f, 2.0f,      2.828427f,
                                           4.0f,      5.656854f, 8.0f};

static const float cosines[DIRECTIONS] = {
    1.0f,  0.92387953f,  0.70710678f,  0.38268343f,  0.0f, -0.38268343f, -0.70710678f, -0.92387953f,
    -1.0f, -0.92387953f, -0.70710678f, -0.38268343f, 0.0f, 0.38268343f,  0.70710678f,  0.92387953f};
static const float sines[DIRECTIONS] = {0.0f,  0.38268343f,  0.70710678f,  0.92387953f,
                                        1.0f,  0.92387953f,  0.70710678f,  0.38268343f,
                                        0.0f,  -0.38268343f, -0.70710678f, -0.92387953f,
                                        -1.0f, -0.92387953f, -0.70710678f, -0.38268343f};

float stp_growth_factor(uint32_t growth)
{
    assert(growth < STP_GROWTHS);
    return factors[growth];
}

typedef struct gap_search {
    const stp_growth_desc* desc;
    stp_grid fine, coarse;
    uint8_t* found;   ///< growth of each point
    uint8_t* growths; ///< the same, and not far above those around it
} gap_search;

/// A point, the plane of its surface, and the cell around it.
typedef struct plane_cell {
    stp_vec3 point, normal, across, along;
    float nearness[DIRECTIONS]; ///< 1 / distance to the border of the cell; 0: no border
    uint32_t steep;             ///< neighbours that are not of the surface
    float reach;                ///< square of the distance from which neighbours change nothing
} plane_cell;

static plane_cell begin_cell(const stp_growth_desc* d, uint32_t index)
{
    const float *p = d->positions + 3 * (size_t)index, *n = d->normals + 3 * (size_t)index;
    plane_cell cell = {
        .point = {p[0], p[1], p[2]}, .normal = {n[0], n[1], n[2]}, .reach = INFINITY};
    stp_vec3 axis =
        fabsf(n[0]) < 0.6f ? (stp_vec3){1.0f, 0.0f, 0.0f} : (stp_vec3){0.0f, 1.0f, 0.0f};
    cell.across = stp_normalize(stp_cross(cell.normal, axis));
    cell.along = stp_cross(cell.normal, cell.across);
    return cell;
}

/// Cuts a cell by the bisector between its point and a neighbour. @return whether it was cut
static bool cut_cell(plane_cell* cell, stp_vec3 offset)
{
    float u = stp_dot(offset, cell->across), v = stp_dot(offset, cell->along);
    float height = stp_dot(offset, cell->normal), square = u * u + v * v;
    if (!(square > 0.0f) || height * height > STEEP * square) {
        cell->steep += square > 0.0f ? 1 : 0;
        return false;
    }
    float a = 2.0f * u / square, b = 2.0f * v / square;
#pragma GCC unroll 1
    for (int k = 0; k < DIRECTIONS; ++k) { // compiled to vectors, unless it is unrolled first
        float nearness = a * cosines[k] + b * sines[k];
        cell->nearness[k] = stp_max(cell->nearness[k], nearness);
    }
    return true;
}

static float least_nearness(const plane_cell* cell)
{
    float least = cell->nearness[0];
    for (int k = 1; k < DIRECTIONS; ++k) {
        least = stp_min(least, cell->nearness[k]);
    }
    return least;
}

static void cut_by_bucket(plane_cell* cell, const stp_grid* grid, uint32_t bucket, uint32_t limit)
{
    uint32_t begin = grid->starts[bucket], end = grid->starts[bucket + 1];
    end = end - begin < limit ? end : begin + limit;
    bool cut = false;
    for (uint32_t at = begin; at < end; ++at) {
        stp_vec3 offset = {grid->x[at] - cell->point.x, grid->y[at] - cell->point.y,
                           grid->z[at] - cell->point.z};
        cut = (stp_dot(offset, offset) < cell->reach && cut_cell(cell, offset)) || cut;
    }
    float least = cut ? least_nearness(cell) : 0.0f;
    if (least > 0.0f) {
        cell->reach = 4.0f * (1.0f + STEEP * STEEP) /
                      (least * least); // steep neighbours are nearer in the plane
    }
}

/// Cuts a cell by the points around it: of its own cell of the grid first, which leaves little to
/// do for the others.
static void cut_by_grid(plane_cell* cell, const stp_grid* grid, uint32_t limit)
{
    int32_t x = stp_grid_cell(grid, cell->point.x), y = stp_grid_cell(grid, cell->point.y),
            z = stp_grid_cell(grid, cell->point.z);
    cut_by_bucket(cell, grid, stp_grid_bucket(grid, x, y, z), limit);
    for (int32_t i = 0; i < 27; ++i) {
        if (i != 13) {
            cut_by_bucket(cell, grid,
                          stp_grid_bucket(grid, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1),
                          limit);
        }
    }
}

/// How far a finished cell reaches, without what may be beyond the border of a surface.
static float reach_of(const stp_growth_desc* d, const plane_cell* cell)
{
    float covered = d->covered + d->radius, reach = 0.0f, closed = 1.0f / (CLOSED * covered);
    bool enclosed = least_nearness(cell) * ENCLOSED * covered >= 1.0f;
    float sided = enclosed ? INNER_SIDED : ONE_SIDED;
    for (int k = 0; k < DIRECTIONS; ++k) {
        float own = cell->nearness[k], opposite = cell->nearness[(k + DIRECTIONS / 2) % DIRECTIONS];
        float beside = stp_min(cell->nearness[(k + 1) % DIRECTIONS],
                               cell->nearness[(k + DIRECTIONS - 1) % DIRECTIONS]);
        float distance = own > 0.0f ? 1.0f / own : INFINITY;
        float limit = stp_min(own, beside) >= closed ? HOLE * covered : covered;
        limit = opposite > 0.0f ? stp_max(limit, sided / opposite) : limit;
        limit = stp_min(limit, d->covered + d->radius * factors[STP_GROWTHS - 1]);
        reach = stp_max(reach, stp_min(distance * BETWEEN, limit));
    }
    return reach;
}

static uint8_t growth_for(const stp_growth_desc* d, float reach)
{
    uint32_t growth = d->smaller ? 0 : STP_GROWTH_PLAIN;
    while (growth + 1 < STP_GROWTHS &&
           (d->covered + d->radius * factors[growth]) * TOLERANCE < reach) {
        growth += 1;
    }
    return (uint8_t)growth;
}

static void search_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    float known = 0.5f * FINE_CELL * s->desc->spacing; // what the fine grid tells about
    for (size_t at = begin; at < end; ++at) {
        uint32_t index = s->fine.index[at];
        plane_cell cell = begin_cell(s->desc, index);
        cut_by_grid(&cell, &s->fine, FINE_POINTS);
        if (!(least_nearness(&cell) * known >= 1.0f) && cell.steep < VOLUME) {
            cut_by_grid(&cell, &s->coarse, COARSE_POINTS);
        }
        s->found[index] = growth_for(s->desc, reach_of(s->desc, &cell));
    }
}

static void count_growths(const gap_search* s, uint32_t bucket, uint32_t index, uint32_t* counts)
{
    const stp_grid* grid = &s->fine;
    uint32_t begin = grid->starts[bucket], end = grid->starts[bucket + 1];
    const float* p = s->desc->positions + 3 * (size_t)index;
    end = end - begin < FINE_POINTS ? end : begin + FINE_POINTS;
    for (uint32_t at = begin; at < end; ++at) {
        stp_vec3 offset = {grid->x[at] - p[0], grid->y[at] - p[1], grid->z[at] - p[2]};
        bool near = stp_dot(offset, offset) <= grid->cell * grid->cell;
        counts[s->found[grid->index[at]]] += near && grid->index[at] != index ? 1 : 0;
    }
}

/// How large the growth of a point may be: OUTSTANDING above the median of the points within a
/// cell's side of it, and STP_GROWTH_PLAIN in any case.
static uint32_t limit_around(const gap_search* s, uint32_t index)
{
    uint32_t counts[STP_GROWTHS] = {0}, total = 0, below = 0, median = 0;
    const float* p = s->desc->positions + 3 * (size_t)index;
    int32_t x = stp_grid_cell(&s->fine, p[0]), y = stp_grid_cell(&s->fine, p[1]),
            z = stp_grid_cell(&s->fine, p[2]);
    for (int32_t i = 0; i < 27; ++i) {
        uint32_t bucket =
            stp_grid_bucket(&s->fine, x + i % 3 - 1, y + i / 3 % 3 - 1, z + i / 9 - 1);
        count_growths(s, bucket, index, counts);
    }
    for (uint32_t k = 0; k < STP_GROWTHS; ++k) {
        total += counts[k];
    }
    if (total == 0) {
        return STP_GROWTH_PLAIN;
    }
    while ((below += counts[median]) * 2 < total) {
        median += 1;
    }
    median += OUTSTANDING;
    return median > STP_GROWTH_PLAIN ? median : STP_GROWTH_PLAIN;
}

/// Limits growths that are far above those around them: of points in the air, whose neighbours in
/// the plane are not of their surface.
static void limit_growths(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const gap_search* s = user;
    for (size_t i = begin; i < end; ++i) {
        s->growths[i] = s->found[i];
        if (s->found[i] > STP_GROWTH_PLAIN) {
            uint32_t most = limit_around(s, (uint32_t)i);
            s->growths[i] = s->found[i] < most ? s->found[i] : (uint8_t)most;
        }
    }
}

stp_result stp_growths_find(stp_context* context, const stp_growth_desc* desc, uint8_t* growths)
{
    assert(desc->spacing > 0.0f && desc->radius > 0.0f && desc->sparse_count <= desc->count);
    gap_search s = {.desc = desc, .growths = growths};
    s.found = STP_NEW_ARRAY(context, uint8_t, desc->count);
    stp_result result = s.found == NULL ? stp_fail_memory(context) : STP_OK;
    result = result != STP_OK ? result
                              : stp_grid_create(context, desc->positions, NULL, desc->count,
                                                FINE_CELL * desc->spacing, 0.0f, &s.fine);
    if (result == STP_OK) {
        result = stp_grid_create(context, desc->positions, NULL, desc->sparse_count,
                                 COARSE_CELL * desc->spacing, 0.0f, &s.coarse);
    }
    if (result == STP_OK) {
        stp_parallel_for(context, desc->count, GRAIN, search_points, &s);
        stp_parallel_for(context, desc->count, GRAIN, limit_growths, &s);
    }
    stp_free(context, s.found);
    stp_grid_destroy(context, &s.coarse);
    stp_grid_destroy(context, &s.fine);
    return result;
}
