// SPDX-License-Identifier: MIT
// Searches among neighbours. Points are on a lattice, so that many distances are equal.
#include "lab/kernels/kernel_cases.h"
#include "lod/blue/growths_kernels.h"
#include "lod/grid.h"
#include "lod/neighbours_kernels.h"
#include "lod/point_normals_kernels.h"

#include <string.h>

enum {
    POINTS = 1 << 14,
    SURFELS = 96,
    DISKS = 512,
    DISK_SAMPLES = 256,
    PLACES = 512,
    AROUND = 128
};
enum { COLUMN = POINTS + 2 * STP_GRID_LANES };

typedef struct lod_input {
    stp_grid grid;
    stp_stencil stencil;
    stp_near_points near;
    stp_around around;
    float x[COLUMN], y[COLUMN], z[COLUMN], nx[COLUMN], ny[COLUMN], nz[COLUMN];
    uint32_t index[COLUMN];
    float sums[PLACES][STP_NORMAL_SUMS];
} lod_input;

static lod_input* make_points(kernel_case* c)
{
    lod_input* in = stp_arena_alloc(c->arena, sizeof(*in));
    if (in == NULL) {
        return NULL;
    }
    memset(in, 0, sizeof(*in));
    for (uint32_t i = 0; i < POINTS; ++i) {
        in->x[i] = 0.05f * (float)stp_rng_below(1, i, 40);
        in->y[i] = 0.05f * (float)stp_rng_below(2, i, 40);
        in->z[i] = 0.05f * (float)stp_rng_below(3, i, 40);
        in->nx[i] = (float)stp_rng_below(4, i, 3) - 1.0f;
        in->ny[i] = (float)stp_rng_below(5, i, 3) - 1.0f;
        in->nz[i] = (float)stp_rng_below(6, i, 3) - 1.0f;
        in->index[i] = i;
    }
    in->grid = (stp_grid){.count = POINTS,
                          .cell = 0.5f,
                          .inverse_cell = 2.0f,
                          .offset = 0.1f,
                          .mask = POINTS - 1,
                          .index = in->index,
                          .x = in->x,
                          .y = in->y,
                          .z = in->z,
                          .nx = in->nx,
                          .ny = in->ny,
                          .nz = in->nz};
    c->input = in;
    return in;
}

bool kernel_make_buckets(kernel_case* c)
{
    return make_points(c) != NULL && kernel_set_output(c, POINTS * sizeof(uint32_t), POINTS);
}

void kernel_run_buckets(kernel_case* c)
{
    const lod_input* in = c->input;
    const stp_grid_points points = {in->x, in->y, in->z, 1};
    stp_grid_kernels_select()->find_buckets(&in->grid, &points, 0, POINTS, c->output);
}

bool kernel_make_nearest(kernel_case* c)
{
    return make_points(c) != NULL &&
           kernel_set_output(c, POINTS * sizeof(uint32_t), (uint64_t)POINTS * SURFELS);
}

/// The first surfels, in two ranges, for runs of a few samples.
void kernel_run_nearest(kernel_case* c)
{
    enum { RUN = 20 };
    const lod_input* in = c->input;
    const stp_near_ranges ranges = {
        .count = 2, .begins = {0, SURFELS}, .ends = {SURFELS / 3, SURFELS + SURFELS * 2 / 3}};
    const stp_near_rule rule = {.limit = 0.5f, .min_agreement = 0.0f};
    const stp_near_kernels* kernels_here = stp_near_kernels_select();
    for (uint32_t at = 0; at < POINTS; at += RUN) {
        uint32_t end = POINTS - at < RUN ? POINTS : at + RUN;
        kernels_here->find_nearest(&in->grid, &ranges, &in->grid, at, end, rule, c->output);
    }
}

bool kernel_make_disks(kernel_case* c)
{
    lod_input* in = make_points(c);
    if (in == NULL) {
        return false;
    }
    in->stencil = stp_stencil_make();
    return kernel_set_output(c, DISKS * sizeof(stp_disk), (uint64_t)DISKS * DISK_SAMPLES);
}

void kernel_run_disks(kernel_case* c)
{
    const lod_input* in = c->input;
    stp_disk* disks = c->output;
    const stp_near_ranges ranges = {.count = 1, .ends = {DISK_SAMPLES}};
    stp_disk_query query = {.limit = 1.5f,
                            .footprint = 0.05f,
                            .first_of_sets = UINT32_MAX,
                            .tangents = {{0.9f, 0.1f, 0.0f}, {-0.1f, 0.9f, 0.3f}},
                            .stencil = &in->stencil};
    const stp_near_kernels* kernels_here = stp_near_kernels_select();
    memset(disks, 0, c->output_bytes);
    for (uint32_t i = 0; i < DISKS; ++i) {
        query.x = in->x[i], query.y = in->y[i], query.z = in->z[i];
        query.nx = in->nx[i], query.ny = in->ny[i], query.nz = in->nz[i];
        kernels_here->scan_disk(&in->grid, &ranges, &query, &disks[i]);
    }
}

bool kernel_make_squared(kernel_case* c)
{
    return make_points(c) != NULL &&
           kernel_set_output(c, PLACES * sizeof(float), (uint64_t)PLACES * DISK_SAMPLES);
}

void kernel_run_squared(kernel_case* c)
{
    const lod_input* in = c->input;
    const stp_near_kernels* kernels_here = stp_near_kernels_select();
    for (uint32_t i = 0; i < PLACES; ++i) {
        const stp_vec3 place = {0.004f * (float)i, 1.0f, 0.5f};
        ((float*)c->output)[i] =
            kernels_here->nearest_squared(in->x, in->y, in->z, DISK_SAMPLES, place);
    }
}

static bool list_near_points(kernel_case* c)
{
    lod_input* in = make_points(c);
    if (in == NULL) {
        return false;
    }
    in->near.count = STP_NEAR_POINTS_MAX;
    memcpy(in->near.x, in->x, sizeof(in->near.x));
    memcpy(in->near.y, in->y, sizeof(in->near.y));
    memcpy(in->near.z, in->z, sizeof(in->near.z));
    return true;
}

static void sum_near(const lod_input* in, float (*sums)[STP_NORMAL_SUMS])
{
    const stp_normal_kernels* kernels_here = stp_normal_kernels_select();
    for (uint32_t i = 0; i < PLACES; ++i) {
        const stp_vec3 place = {in->x[i], in->y[i], in->z[i]};
        kernels_here->sum_near(&in->near, 0.8f, place, sums[i]);
    }
}

bool kernel_make_sums(kernel_case* c)
{
    return list_near_points(c) && kernel_set_output(c, sizeof(((lod_input*)c->input)->sums),
                                                    (uint64_t)PLACES * STP_NEAR_POINTS_MAX);
}

void kernel_run_sums(kernel_case* c)
{
    sum_near(c->input, c->output);
}

bool kernel_make_planes(kernel_case* c)
{
    if (!list_near_points(c)) {
        return false;
    }
    lod_input* in = c->input;
    sum_near(in, in->sums);
    for (uint32_t i = 0; i < PLACES; ++i) {
        in->sums[i][0] = stp_max(in->sums[i][0], 1.0f); // at least one point
    }
    return kernel_set_output(c, sizeof(float[PLACES][STP_NORMAL_MATRIX]), PLACES);
}

void kernel_run_planes(kernel_case* c)
{
    const lod_input* in = c->input;
    stp_normal_kernels_select()->project(in->sums, PLACES, c->output);
}

bool kernel_make_growths(kernel_case* c)
{
    lod_input* in = make_points(c);
    if (in == NULL) {
        return false;
    }
    in->around.count = AROUND;
    memcpy(in->around.x, in->x, AROUND * sizeof(float));
    memcpy(in->around.y, in->y, AROUND * sizeof(float));
    memcpy(in->around.z, in->z, AROUND * sizeof(float));
    return kernel_set_output(c, PLACES * sizeof(float), (uint64_t)PLACES * AROUND);
}

void kernel_run_growths(kernel_case* c)
{
    const lod_input* in = c->input;
    const stp_growth_kernels* kernels_here = stp_growth_kernels_select();
    const stp_cell_limits limits = {
        .plain = 0.2f, .closed = 1.5f, .hole = 0.4f, .enclosed = 1.0f, .most = 1.0f};
    for (uint32_t i = 0; i < PLACES; ++i) {
        stp_plane_cell cell = {.point = {in->x[i], in->y[i], in->z[i]},
                               .normal = {0.0f, 0.0f, 1.0f},
                               .across = {0.8f, 0.6f, 0.0f},
                               .along = {-0.6f, 0.8f, 0.0f},
                               .beyond = INFINITY};
        kernels_here->cut(&in->around, 0.0f, 0.1f, 0.1f, &cell);
        ((float*)c->output)[i] = kernels_here->reach(&limits, &cell);
    }
}
