// SPDX-License-Identifier: MIT
//
// Estimates normals of a point cloud without normals: the direction of least spread among
// neighbours (Hoppe et al. Surface Reconstruction from Unorganized Points. 1992). Does not
// determine the outside.
#include "base/math.h"
#include "base/processor.h"
#include "lod/cloud_candidates.h"
#include "lod/point_normals_kernels.h"

#include <string.h>

enum {
    GRAIN = 4096,
    BATCH = 64, ///< points summed together
    LEAST_NEIGHBOURS = 4,
    DOUBLINGS = 4, ///< maximum enlargement of the radius, for points with fewer neighbours
};

typedef struct normal_search {
    const stp_grid* grid;
    float radius;
    const stp_normal_kernels* kernels;
    stp_candidates* candidates;
    uint32_t point_count; ///< number of points; surfels of sets follow
    uint8_t* lonely;      ///< by candidate: 1 if it has too few neighbours so far
} normal_search;

/// Extracts the remaining eigenvector of a matrix (stp_normal_kernels).
static stp_vec3 direction_of(const double m[STP_NORMAL_MATRIX])
{
    // the diagonal of a projection holds the squares of the direction's coordinates
    double xx = m[0], yy = m[3], zz = m[5];
    stp_vec3d n = {xx, m[1], m[2]};
    if (yy > xx && yy >= zz) {
        n = (stp_vec3d){m[1], yy, m[4]};
    } else if (zz > xx) {
        n = (stp_vec3d){m[2], m[4], zz};
    }
    stp_vec3 direction = stp_to_float(stp_normalized(n));
    return direction.y < 0.0f ? stp_scale(direction, -1.0f) : direction;
}

/// Sets the normal of the candidate at a grid index, from the number of its neighbours and their
/// matrix.
static void take_normal(const normal_search* s, size_t at, float neighbours,
                        const double matrix[STP_NORMAL_MATRIX])
{
    uint32_t index = s->grid->index[at];
    if (index >= s->point_count) {
        return;
    }
    stp_vec3 normal = {0, 1, 0};
    bool lonely = neighbours < (float)LEAST_NEIGHBOURS;
    if (!lonely) {
        normal = direction_of(matrix);
        normal = stp_dot(normal, normal) > 0.0f ? normal : (stp_vec3){0, 1, 0};
    }
    memcpy(s->candidates->normals + 3 * (size_t)index, &normal, sizeof(normal));
    s->lonely[index] = lonely ? 1 : 0;
}

/// Normals of at most BATCH consecutive points in the grid.
static void estimate_batch(const normal_search* s, size_t begin, size_t end)
{
    float sums[BATCH][STP_NORMAL_SUMS];
    double matrices[BATCH][STP_NORMAL_MATRIX];
    s->kernels->sum_neighbours(s->grid, s->radius, begin, end, sums);
    s->kernels->project((const float(*)[STP_NORMAL_SUMS])sums, end - begin, matrices);
    for (size_t at = begin; at < end; ++at) {
        take_normal(s, at, sums[at - begin][0], matrices[at - begin]);
    }
}

static void estimate_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_search* s = user;
    for (size_t first = begin; first < end; first += BATCH) {
        estimate_batch(s, first, first + BATCH < end ? first + BATCH : end);
    }
}

/// The same for points with too few neighbours so far.
static void estimate_lonely(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_search* s = user;
    for (size_t at = begin; at < end; ++at) {
        uint32_t index = s->grid->index[at];
        if (index < s->point_count && s->lonely[index] != 0) {
            estimate_batch(s, at, at + 1);
        }
    }
}

static const stp_normal_kernels* choose_kernels(void)
{
#if defined(__x86_64__)
    if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
        return &stp_normal_kernels_avx2;
    }
#endif
    return &stp_normal_kernels_portable;
}

static bool has_lonely(const normal_search* s)
{
    return memchr(s->lonely, 1, s->point_count) != NULL;
}

/// One pass over all points, or over those with too few neighbours.
static stp_result search_within(stp_context* context, normal_search* s, float radius, bool all)
{
    const stp_candidates* c = s->candidates;
    stp_grid grid;
    stp_result result = stp_grid_create_uncrowded(context, c->positions, NULL, c->count,
                                                  STP_NORMAL_CELL * radius, &grid);
    if (result != STP_OK) {
        return result;
    }
    s->grid = &grid;
    s->radius = grid.cell / STP_NORMAL_CELL;
    stp_parallel_for(context, c->count, GRAIN, all ? estimate_normals : estimate_lonely, s);
    stp_grid_destroy(context, &grid);
    return STP_OK;
}

stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                      float radius)
{
    uint32_t point_count = stp_first_of_sets(candidates);
    if (!(radius > 0.0f) || point_count == 0) {
        return STP_OK;
    }
    normal_search search = {.kernels = choose_kernels(),
                            .candidates = candidates,
                            .point_count = point_count,
                            .lonely = STP_NEW_ZEROED(context, uint8_t, point_count)};
    if (search.lonely == NULL) {
        return stp_fail_memory(context);
    }
    stp_result result = search_within(context, &search, radius, true);
    for (int i = 0; i < DOUBLINGS && result == STP_OK && has_lonely(&search); ++i) {
        radius *= 2.0f;
        result = search_within(context, &search, radius, false);
    }
    stp_free(context, search.lonely);
    return result;
}
