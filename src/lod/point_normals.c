// SPDX-License-Identifier: MIT
//
// Normals of a point cloud that has none: the direction in which the points around one lie flattest (Hoppe et
// al. Surface Reconstruction from Unorganized Points. 1992). Which side is outside stays open.
#include "base/math.h"
#include "base/processor.h"
#include "lod/point_normals_kernels.h"
#include "lod/points.h"

#include <string.h>

enum {
    GRAIN = 4096,
    BATCH = 64,          ///< points whose sums are made together
    MOST_SQUARINGS = 12, ///< of the matrix: its 4096th power
    LEAST_NEIGHBOURS = 4,
    DOUBLINGS = 4, ///< of the radius, for points that have fewer
};
#define CONVERGED 1e-12 // what else than the largest eigenvalue leaves of the trace

typedef struct normal_search {
    const stp_grid* grid;
    float radius;
    stp_sum_neighbours* sum_neighbours;
    stp_candidates* candidates;
    uint32_t point_count; ///< surfels of sets come after them
    uint8_t* lonely;      ///< by candidate: 1 where it has too few neighbours so far
} normal_search;

/// A symmetric matrix.
typedef struct symmetric {
    double xx, xy, xz, yy, yz, zz;
} symmetric;

static symmetric scaled(const symmetric* m, double s)
{
    return (symmetric){m->xx * s, m->xy * s, m->xz * s, m->yy * s, m->yz * s, m->zz * s};
}

static symmetric squared(const symmetric* m)
{
    return (symmetric){
        .xx = m->xx * m->xx + m->xy * m->xy + m->xz * m->xz,
        .xy = m->xx * m->xy + m->xy * m->yy + m->xz * m->yz,
        .xz = m->xx * m->xz + m->xy * m->yz + m->xz * m->zz,
        .yy = m->xy * m->xy + m->yy * m->yy + m->yz * m->yz,
        .yz = m->xy * m->xz + m->yy * m->yz + m->yz * m->zz,
        .zz = m->xz * m->xz + m->yz * m->yz + m->zz * m->zz,
    };
}

/// The eigenvector of the least eigenvalue of the covariance C: powers of (trace I - C), of trace 1, turn every column
/// to it. Where only that one is left, the trace of the square is 1. Only products and sums: the same bits everywhere.
static stp_vec3 flattest_direction(const float sums[STP_NORMAL_SUMS])
{
    double weight = 1.0 / (double)sums[0];
    double x = (double)sums[1] * weight, y = (double)sums[2] * weight, z = (double)sums[3] * weight;
    symmetric c = {.xx = (double)sums[4] * weight - x * x,
                   .xy = (double)sums[5] * weight - x * y,
                   .xz = (double)sums[6] * weight - x * z,
                   .yy = (double)sums[7] * weight - y * y,
                   .yz = (double)sums[8] * weight - y * z,
                   .zz = (double)sums[9] * weight - z * z};
    symmetric m = {c.yy + c.zz, -c.xy, -c.xz, c.xx + c.zz, -c.yz, c.xx + c.yy};
    for (int i = 0; i < MOST_SQUARINGS; ++i) {
        double trace = m.xx + m.yy + m.zz;
        m = scaled(&m, trace > 0.0 ? 1.0 / trace : 0.0);
        m = squared(&m);
        if (m.xx + m.yy + m.zz > 1.0 - CONVERGED) {
            break;
        }
    }
    // the diagonal of a projection holds the squares of the direction's coordinates
    stp_vec3d n = {m.xx, m.xy, m.xz};
    if (m.yy > m.xx && m.yy >= m.zz) {
        n = (stp_vec3d){m.xy, m.yy, m.yz};
    } else if (m.zz > m.xx) {
        n = (stp_vec3d){m.xz, m.yz, m.zz};
    }
    stp_vec3 direction = stp_to_float(stp_normalized(n));
    return direction.y < 0.0f ? stp_scale(direction, -1.0f) : direction;
}

/// Takes the normal of the candidate at a place of the grid from the sums of its neighbours.
static void take_normal(const normal_search* s, size_t at, const float sums[STP_NORMAL_SUMS])
{
    uint32_t index = s->grid->index[at];
    if (index >= s->point_count) {
        return;
    }
    stp_vec3 normal = {0, 1, 0};
    bool lonely = sums[0] < (float)LEAST_NEIGHBOURS;
    if (!lonely) {
        normal = flattest_direction(sums);
        normal = stp_dot(normal, normal) > 0.0f ? normal : (stp_vec3){0, 1, 0};
    }
    memcpy(s->candidates->normals + 3 * (size_t)index, &normal, sizeof(normal));
    s->lonely[index] = lonely ? 1 : 0;
}

static void estimate_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_search* s = user;
    float sums[BATCH][STP_NORMAL_SUMS];
    for (size_t first = begin; first < end; first += BATCH) {
        size_t last = first + BATCH < end ? first + BATCH : end;
        s->sum_neighbours(s->grid, s->radius, first, last, sums);
        for (size_t at = first; at < last; ++at) {
            take_normal(s, at, sums[at - first]);
        }
    }
}

/// The same of points that have too few neighbours so far.
static void estimate_lonely(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_search* s = user;
    float sums[1][STP_NORMAL_SUMS];
    for (size_t at = begin; at < end; ++at) {
        uint32_t index = s->grid->index[at];
        if (index < s->point_count && s->lonely[index] != 0) {
            s->sum_neighbours(s->grid, s->radius, at, at + 1, sums);
            take_normal(s, at, sums[0]);
        }
    }
}

static stp_sum_neighbours* choose_kernel(void)
{
#if defined(__x86_64__)
    if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
        return stp_sum_neighbours_avx2;
    }
#endif
    return stp_sum_neighbours_portable;
}

static bool has_lonely(const normal_search* s)
{
    return memchr(s->lonely, 1, s->point_count) != NULL;
}

/// One pass over all points, or over those that had too few neighbours.
static stp_result search_within(stp_context* context, normal_search* s, float radius, bool all)
{
    const stp_candidates* c = s->candidates;
    stp_grid grid;
    stp_result result = stp_grid_create_uncrowded(context, c->positions, c->normals, c->count,
                                                  2.002f * radius, &grid);
    if (result != STP_OK) {
        return result;
    }
    s->grid = &grid;
    s->radius = grid.cell / 2.002f;
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
    normal_search search = {.sum_neighbours = choose_kernel(),
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
