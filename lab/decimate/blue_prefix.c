// SPDX-License-Identifier: MIT
// A prefix of the exact order, with a disk for each of its points: the smallest that covers the
// points nearest to it.
#include "base/core/jobs.h"
#include "lab/decimate/octree_cells.h"
#include "lab/decimate/point_disks.h"

#include <stipple/order.h>

#include <assert.h>

enum { GRAIN = 64 };

typedef struct blue_maker {
    const stp_decimate_input* input;
    const stp_ellipse* disks;
    const uint32_t* neighbours;
    const uint32_t* chosen;
    const stp_decimate_cells* cells;
    stp_decimate_output* output;
} blue_maker;

static float reach_of(stp_vec3 center, stp_vec3 normal, stp_vec3 point)
{
    stp_vec3 d = stp_sub(point, center);
    return stp_length(stp_sub(d, stp_scale(normal, stp_dot(d, normal))));
}

static bool face_apart(const stp_decimate_input* input, uint32_t a, uint32_t b)
{
    return input->normals != NULL && stp_dot(stp_decimate_vector(input->normals, a),
                                             stp_decimate_vector(input->normals, b)) < 0.0f;
}

/// Radius of a disk needed to cover a point of its cell, and half the distance to the point's
/// neighbours in other cells.
static float reach_for(const blue_maker* m, uint32_t cell, stp_vec3 center, stp_vec3 normal,
                       uint32_t point)
{
    const float* positions = m->input->positions;
    const uint32_t* near = m->neighbours + (size_t)STP_DECIMATE_NEIGHBOURS * point;
    stp_vec3 p = stp_decimate_vector(positions, point);
    float reach = reach_of(center, normal, p);
    for (int n = 0; n < STP_DECIMATE_NEIGHBOURS && near[n] != UINT32_MAX; ++n) {
        if (m->cells->owners[near[n]] == cell || face_apart(m->input, point, near[n])) {
            continue;
        }
        stp_vec3 way = stp_sub(stp_decimate_vector(positions, near[n]), p);
        reach = fmaxf(reach, reach_of(center, normal, stp_add(p, stp_scale(way, 0.5f))));
    }
    return reach;
}

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const blue_maker* m = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const stp_ellipse* disk = &m->disks[m->chosen[i]];
        stp_vec3 given = {0}, normal = disk->normal;
        if (m->input->normals != NULL) {
            given = stp_normalize(stp_decimate_vector(m->input->normals, m->chosen[i]));
            normal = stp_dot(given, given) > 0.0f ? given : normal;
        }
        stp_color_mean mean = {0};
        float reach = 0.0f;
        assert(m->cells->starts[i] <= m->cells->starts[i + 1]);
        for (uint32_t at = m->cells->starts[i]; at < m->cells->starts[i + 1]; ++at) {
            uint32_t point = m->cells->members[at];
            float needed = reach_for(m, (uint32_t)i, disk->center, normal, point);
            reach = needed > reach ? needed : reach;
            stp_color_mean_add(&mean, m->input, point, 1.0);
        }
        reach = reach > 0.0f ? reach : disk->minor;
        m->output->ellipses[i] = stp_ellipse_cover(disk->center, normal, NULL, 0, reach);
        stp_color_mean_write(&mean, m->output->colors + 3 * i);
    }
}

static stp_result make_splats(stp_context* context, blue_maker* m, uint32_t target,
                              uint32_t* chosen)
{
    const stp_decimate_input* input = m->input;
    const stp_order_desc desc = {.kind = STP_ORDER_EXACT,
                                 .metric = input->normals != NULL ? STP_METRIC_SIDE
                                                                  : STP_METRIC_EUCLIDEAN};
    stp_decimate_cells cells = {0};
    uint32_t count = 0;
    float radius = 0.0f;
    stp_result result = stp_order_points(context, &desc, input->positions, input->normals,
                                         input->count, target, chosen, NULL, &count, &radius, NULL);
    if (result == STP_OK) {
        assert(count <= target && count <= input->count);
        result = stp_decimate_cells_make(context, input, chosen, count, radius, &cells);
    }
    result = result == STP_OK ? stp_decimate_make_room(context, m->output, count) : result;
    if (result == STP_OK) {
        m->chosen = chosen;
        m->cells = &cells;
        stp_parallel_for(context, count, GRAIN, make_some, m);
    }
    stp_decimate_cells_destroy(context, &cells);
    return result;
}

stp_result stp_decimate_by_blue(stp_context* context, const stp_decimate_input* input,
                                uint32_t target, stp_decimate_output* output)
{
    *output = (stp_decimate_output){0};
    stp_ellipse* disks = NULL;
    uint32_t *neighbours = NULL, *chosen = NULL;
    stp_result result = stp_decimate_check(context, input);
    if (result == STP_OK) {
        result = stp_decimate_make_disks(context, input, &disks, &neighbours);
    }
    if (result == STP_OK) {
        uint32_t maximum = target < input->count ? target : input->count;
        chosen = STP_NEW_ARRAY(context, uint32_t, (size_t)maximum + 1);
        result = chosen != NULL ? STP_OK : stp_fail_memory(context);
    }
    if (result == STP_OK) {
        blue_maker m = {.input = input, .disks = disks, .neighbours = neighbours, .output = output};
        result = make_splats(context, &m, target, chosen);
    }
    stp_free(context, chosen);
    stp_free(context, neighbours);
    stp_free(context, disks);
    return result;
}
