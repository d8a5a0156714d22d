// SPDX-License-Identifier: MIT
#include "lab/decimate/octree_cells.h"
#include "lab/decimate/point_disks.h"
#include "lod/neighbours.h"

#include <assert.h>
#include <string.h>

#define SLACK 1.001f   ///< distances are rounded
#define ROUNDING 1e-7f ///< relative rounding error of coordinates

/// Minimum radius for grids: limited by the precision of coordinates.
static float min_radius(const stp_decimate_input* input)
{
    float maximum = 0.0f;
    for (size_t i = 0; i < 3 * (size_t)input->count; ++i) {
        maximum = fmaxf(maximum, fabsf(input->positions[i]));
    }
    return fmaxf(ROUNDING * maximum, FLT_MIN);
}

/// Finds the nearest chosen point for points without an owner: on the same side or, if
/// `two_sided`, on both.
static void search(stp_context* context, const stp_grid* from, const stp_grid* points, float radius,
                   bool two_sided, uint32_t* nearest, stp_decimate_cells* cells)
{
    const stp_nearest_search search = {.surfels = from,
                                       .samples = points,
                                       .radius = radius,
                                       .two_sided = two_sided,
                                       .nearest = nearest};
    stp_nearest_search_run(context, &search);
    for (uint32_t i = 0; i < points->count; ++i) {
        uint32_t* owner = &cells->owners[points->index[i]];
        *owner = *owner == UINT32_MAX ? nearest[i] : *owner;
    }
}

static stp_result find_owners(stp_context* context, const stp_decimate_input* input,
                              const float* positions, const float* normals, uint32_t count,
                              float radius, stp_decimate_cells* cells)
{
    stp_grid from = {0}, points = {0};
    bool sides = input->normals != NULL;
    const float* all = sides ? input->normals : input->positions; // unused
    uint32_t* nearest = STP_NEW_ARRAY(context, uint32_t, (size_t)input->count + STP_GRID_LANES);
    stp_result result = nearest != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        result = stp_grid_create(context, positions, normals, count, 2.0f * radius, 0.0f, &from);
    }
    if (result == STP_OK) {
        result = stp_grid_create(context, input->positions, all, input->count, from.cell,
                                 0.5f * from.cell, &points);
    }
    if (result == STP_OK) {
        memset(cells->owners, 0xff, input->count * sizeof(*cells->owners));
        if (sides) {
            search(context, &from, &points, radius, false, nearest, cells);
        }
        search(context, &from, &points, radius, true, nearest, cells);
    }
    stp_grid_destroy(context, &from);
    stp_grid_destroy(context, &points);
    stp_free(context, nearest);
    return result;
}

static void list_members(const stp_decimate_input* input, uint32_t count, stp_decimate_cells* cells)
{
    uint32_t before = 0;
    for (uint32_t i = 0; i < input->count; ++i) {
        cells->owners[i] = cells->owners[i] < count ? cells->owners[i] : 0;
        cells->starts[cells->owners[i]] += 1;
    }
    for (uint32_t c = 0; c <= count; ++c) {
        uint32_t own = cells->starts[c];
        cells->starts[c] = before;
        before += own;
    }
    for (uint32_t i = 0; i < input->count; ++i) {
        cells->members[cells->starts[cells->owners[i]]++] = i;
    }
    memmove(cells->starts + 1, cells->starts, count * sizeof(*cells->starts));
    cells->starts[0] = 0;
    assert(cells->starts[count] == input->count && "each point is in one cell");
}

stp_result stp_decimate_cells_make(stp_context* context, const stp_decimate_input* input,
                                   const uint32_t* chosen, uint32_t count, float radius,
                                   stp_decimate_cells* cells)
{
    assert(count <= input->count && !(radius < 0.0f));
    size_t points = input->count;
    *cells = (stp_decimate_cells){.owners = STP_NEW_ARRAY(context, uint32_t, points + 1),
                                  .starts = STP_NEW_ZEROED(context, uint32_t, (size_t)count + 2),
                                  .members = STP_NEW_ARRAY(context, uint32_t, points + 1)};
    float* copies = STP_NEW_ARRAY(context, float, 6 * (size_t)count + 1);
    stp_result result =
        cells->owners != NULL && cells->starts != NULL && cells->members != NULL && copies != NULL
            ? STP_OK
            : stp_fail_memory(context);
    if (result == STP_OK && count > 0) {
        float *positions = copies, *normals = copies + 3 * (size_t)count;
        const float* from = input->normals != NULL ? input->normals : input->positions;
        for (uint32_t i = 0; i < count; ++i) {
            assert(chosen[i] < input->count);
            memcpy(positions + 3 * (size_t)i, input->positions + 3 * (size_t)chosen[i],
                   3 * sizeof(float));
            memcpy(normals + 3 * (size_t)i, from + 3 * (size_t)chosen[i], 3 * sizeof(float));
        }
        radius = fmaxf(SLACK * radius, min_radius(input));
        result = find_owners(context, input, positions, normals, count, radius, cells);
    }
    if (result == STP_OK && count > 0) {
        list_members(input, count, cells);
    }
    stp_free(context, copies);
    return result;
}

void stp_decimate_cells_destroy(stp_context* context, stp_decimate_cells* cells)
{
    stp_free(context, cells->owners);
    stp_free(context, cells->starts);
    stp_free(context, cells->members);
    *cells = (stp_decimate_cells){0};
}
