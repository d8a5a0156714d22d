// SPDX-License-Identifier: MIT
#include "import/reading/scan_values.h"

#include <assert.h>
#include <string.h>

/// Maximum ratio of the distances to opposite neighbours; above it, the farther one is behind a
/// depth jump
#define JUMP 4.0f
/// Maximum difference in distance to a neighbour, relative to the distance to the scanner
#define STEEP 0.5f
#define GRAIN ((size_t)16) ///< columns
#define POINT_GRAIN ((size_t)1 << 16)

typedef struct work {
    stp_cloud* cloud;
    const stp_scan_grid* grid;
} work;

// The point of a cell; STP_NONE if it is empty or outside the grid.
static uint32_t point_at(const work* w, int64_t column, int64_t row)
{
    const stp_scan_grid* g = w->grid;
    if (column < 0 || row < 0 || column >= g->columns || row >= g->rows) {
        return STP_NONE;
    }
    size_t cell = (size_t)column * g->rows + (size_t)row;
    uint32_t point = g->cells != NULL ? g->cells[cell] : (uint32_t)cell;
    assert(point == STP_NONE || point < w->cloud->set.point_count);
    return point != STP_NONE && !stp_cloud_is_empty(w->cloud, point) ? point : STP_NONE;
}

static stp_vec3 position(const work* w, uint32_t point)
{
    const float* p = w->cloud->set.positions + 3 * (size_t)point;
    return (stp_vec3){p[0], p[1], p[2]};
}

typedef struct grid_step {
    stp_vec3 vector;
    float squared; ///< squared length; 0: there is no neighbour on the same surface
} grid_step;

// The step from p to a neighbour within a distance, given squared.
static grid_step step_to(const work* w, stp_vec3 p, uint32_t neighbour, float squared_reach)
{
    if (neighbour == STP_NONE) {
        return (grid_step){0};
    }
    stp_vec3 step = stp_sub(position(w, neighbour), p);
    float squared = stp_dot(step, step);
    return squared <= squared_reach ? (grid_step){step, squared} : (grid_step){0};
}

// The difference along one direction of the grid: between both neighbours, or to the nearer one.
static stp_vec3 difference(grid_step back, grid_step on)
{
    float shorter = stp_min(back.squared, on.squared), longer = stp_max(back.squared, on.squared);
    if (longer <= JUMP * JUMP * shorter) {
        return stp_sub(on.vector, back.vector);
    }
    bool take_back = (shorter == 0.0f) == (back.squared > on.squared);
    return take_back ? stp_scale(back.vector, -1.0f) : on.vector;
}

static void store_normal(const work* w, uint32_t point, stp_vec3 across)
{
    stp_vec3 toward = stp_sub(w->grid->scanner, position(w, point));
    stp_vec3 n = stp_normalize(across);
    if (stp_dot(n, n) == 0.0f) {
        n = stp_normalize(toward);
    } else if (stp_dot(n, toward) < 0.0f) {
        n = stp_scale(n, -1.0f);
    }
    memcpy(w->cloud->set.normals + 3 * (size_t)point, &n, sizeof(n));
}

static void clear_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const work* w = user;
    memset(w->cloud->set.normals + 3 * begin, 0, (end - begin) * 3 * sizeof(float));
}

// Points that are in no cell.
static void face_scanner(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const work* w = user;
    for (size_t i = begin; i < end; ++i) {
        const float* n = w->cloud->set.normals + 3 * i;
        if (n[0] == 0.0f && n[1] == 0.0f && n[2] == 0.0f) {
            store_normal(w, (uint32_t)i, (stp_vec3){0});
        }
    }
}

static void fill_columns(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const work* w = user;
    for (int64_t c = (int64_t)begin; c < (int64_t)end; ++c) {
        for (int64_t r = 0; r < w->grid->rows; ++r) {
            uint32_t point = point_at(w, c, r);
            if (point != STP_NONE) {
                stp_vec3 p = position(w, point), toward = stp_sub(w->grid->scanner, p);
                float reach = STEEP * STEEP * stp_dot(toward, toward);
                stp_vec3 along = difference(step_to(w, p, point_at(w, c - 1, r), reach),
                                            step_to(w, p, point_at(w, c + 1, r), reach));
                stp_vec3 up = difference(step_to(w, p, point_at(w, c, r - 1), reach),
                                         step_to(w, p, point_at(w, c, r + 1), reach));
                store_normal(w, point, stp_cross(along, up));
            }
        }
    }
}

void stp_grid_normals(stp_cloud* cloud, const stp_scan_grid* grid)
{
    work w = {cloud, grid};
    stp_context* context = cloud->import->context;
    if (cloud->set.point_count == 0) { // there may be any number of empty columns
        return;
    }
    assert(cloud->set.normals != NULL);
    assert(grid->cells != NULL || (uint64_t)grid->columns * grid->rows == cloud->set.point_count);
    if (grid->cells != NULL) {
        stp_parallel_for(context, cloud->set.point_count, POINT_GRAIN, clear_normals, &w);
    }
    stp_parallel_for(context, grid->columns, GRAIN, fill_columns, &w);
    if (grid->cells != NULL) {
        stp_parallel_for(context, cloud->set.point_count, POINT_GRAIN, face_scanner, &w);
    }
}
