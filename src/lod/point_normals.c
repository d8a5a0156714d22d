// SPDX-License-Identifier: MIT
//
// Normals of a point cloud that has none: the direction in which the points around one lie flattest (Hoppe et
// al. Surface Reconstruction from Unorganized Points. 1992). Which side is outside stays open.
#include "base/math.h"
#include "lod/grid.h"
#include "lod/points.h"

#include <string.h>

#define GRAIN 4096
#define SQUARINGS 12 // of the matrix: its 4096th power
#define LEAST_NEIGHBOURS 4u

typedef struct normal_search {
    const stp_grid* grid;
    float radius;
    stp_candidates* candidates;
} normal_search;

// Sums over the neighbours of one point: offsets, and products of offsets.
typedef struct moments {
    double sum[3], products[3][3];
    uint32_t count;
} moments;

static void add_cell(const normal_search* s, const float* p, int32_t x, int32_t y, int32_t z,
                     moments* m)
{
    const stp_grid* grid = s->grid;
    uint32_t bucket = stp_grid_bucket(grid, x, y, z);
    for (uint32_t at = grid->starts[bucket]; at < grid->starts[bucket + 1]; ++at) {
        double d[3] = {(double)(grid->x[at] - p[0]), (double)(grid->y[at] - p[1]),
                       (double)(grid->z[at] - p[2])};
        double squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
        if (squared > (double)s->radius * (double)s->radius) {
            continue;
        }
        for (int i = 0; i < 3; ++i) {
            m->sum[i] += d[i];
            for (int k = 0; k < 3; ++k) {
                m->products[i][k] += d[i] * d[k];
            }
        }
        m->count += 1;
    }
}

static void square_matrix(double m[3][3])
{
    double out[3][3], most = 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            out[i][k] = m[i][0] * m[0][k] + m[i][1] * m[1][k] + m[i][2] * m[2][k];
            most = fabs(out[i][k]) > most ? fabs(out[i][k]) : most;
        }
    }
    double scale = most > 0.0 ? 1.0 / most : 0.0;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            m[i][k] = out[i][k] * scale;
        }
    }
}

// The eigenvector of the least eigenvalue of the covariance C: powers of (trace I - C) turn every column to
// it. Only products and sums: the same bits everywhere.
static stp_vec3 flattest_direction(const moments* m)
{
    double matrix[3][3], trace = 0.0, weight = 1.0 / (double)m->count;
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 3; ++k) {
            matrix[i][k] = -(m->products[i][k] * weight - m->sum[i] * m->sum[k] * weight * weight);
        }
        trace -= matrix[i][i];
    }
    for (int i = 0; i < 3; ++i) {
        matrix[i][i] += trace;
    }
    for (int i = 0; i < SQUARINGS; ++i) {
        square_matrix(matrix);
    }
    int longest =
        0; // the diagonal of a projection holds the squares of the direction's coordinates
    longest = matrix[1][1] > matrix[longest][longest] ? 1 : longest;
    longest = matrix[2][2] > matrix[longest][longest] ? 2 : longest;
    stp_vec3 n = stp_normalize((stp_vec3){(float)matrix[0][longest], (float)matrix[1][longest],
                                          (float)matrix[2][longest]});
    return n.y < 0.0f ? stp_scale(n, -1.0f) : n;
}

static void estimate_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_search* s = user;
    const stp_grid* grid = s->grid;
    for (size_t at = begin; at < end; ++at) {
        float p[3] = {grid->x[at], grid->y[at], grid->z[at]};
        int32_t cell[3];
        for (int axis = 0; axis < 3; ++axis) {
            cell[axis] = stp_grid_cell(grid, p[axis] - s->radius);
        }
        moments m = {.count = 0};
        for (int corner = 0; corner < 8; ++corner) {
            add_cell(s, p, cell[0] + (corner & 1), cell[1] + (corner >> 1 & 1),
                     cell[2] + (corner >> 2), &m);
        }
        stp_vec3 normal = {0, 1, 0};
        if (m.count >= LEAST_NEIGHBOURS) {
            normal = flattest_direction(&m);
            normal = stp_dot(normal, normal) > 0.0f ? normal : (stp_vec3){0, 1, 0};
        }
        memcpy(s->candidates->normals + 3 * (size_t)grid->index[at], &normal, sizeof(normal));
    }
}

stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                      float radius)
{
    if (!(radius > 0.0f)) {
        return STP_OK;
    }
    stp_grid grid;
    stp_result result =
        stp_grid_create_uncrowded(context, candidates->positions, candidates->normals,
                                  candidates->count, 2.002f * radius, &grid);
    if (result == STP_OK) {
        normal_search search = {
            .grid = &grid, .radius = grid.cell / 2.002f, .candidates = candidates};
        stp_parallel_for(context, candidates->count, GRAIN, estimate_normals, &search);
        stp_grid_destroy(context, &grid);
    }
    return result;
}
