// SPDX-License-Identifier: MIT
#include "lod/psp/initial.h"

#include "base/jobs.h"
#include "lod/psp/nearest_points.h"

typedef struct initial {
    const stp_psp_points* points;
    stp_ellipse* ellipses;
    const uint32_t* neighbours;
    uint32_t k;
    float alone; ///< radius of a splat without neighbours
} initial;

static stp_vec3 vector_at(const float* values, size_t index)
{
    return (stp_vec3){values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

/// The normal of the plane nearest to a point and its neighbours.
static stp_vec3 find_normal(const initial* in, uint32_t point)
{
    const uint32_t* near = in->neighbours + (size_t)in->k * point;
    stp_vec3 p = vector_at(in->points->positions, point);
    double sum[3] = {0}, m[6] = {0}, count = 1.0, eigenvalues[3];
    for (uint32_t i = 0; i < in->k && near[i] != UINT32_MAX; ++i) {
        stp_vec3 q = stp_sub(vector_at(in->points->positions, near[i]), p);
        const double d[3] = {(double)q.x, (double)q.y, (double)q.z};
        for (int a = 0, at = 0; a < 3; ++a) {
            sum[a] += d[a];
            for (int b = a; b < 3; ++b) {
                m[at++] += d[a] * d[b];
            }
        }
        count += 1.0;
    }
    for (int a = 0, at = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b) {
            m[at++] -= sum[a] * sum[b] / count;
        }
    }
    stp_vec3d found = stp_least_direction(m, eigenvalues);
    stp_vec3 n = stp_normalize((stp_vec3){(float)found.x, (float)found.y, (float)found.z});
    stp_vec3 given =
        in->points->normals != NULL ? vector_at(in->points->normals, point) : (stp_vec3){0};
    float side = stp_dot(n, given);
    if (!(m[0] + m[3] + m[5] > 0.0) && stp_dot(given, given) > 0.0f) {
        return stp_normalize(given); // all are in one place
    }
    if (side == 0.0f) {
        float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
        side = x >= y && x >= z ? n.x : y >= z ? n.y : n.z;
    }
    return side < 0.0f ? stp_scale(n, -1.0f) : n;
}

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const initial* in = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        const uint32_t* near = in->neighbours + in->k * i;
        stp_vec3 p = vector_at(in->points->positions, i), n = find_normal(in, (uint32_t)i);
        float radius = 0.0f;
        for (uint32_t k = 0; k < in->k && near[k] != UINT32_MAX; ++k) {
            stp_vec3 d = stp_sub(vector_at(in->points->positions, near[k]), p);
            d = stp_sub(d, stp_scale(n, stp_dot(d, n)));
            radius = fmaxf(radius, stp_length(d));
        }
        in->ellipses[i] = stp_ellipse_cover(p, n, NULL, 0, radius > 0.0f ? radius : in->alone);
    }
}

stp_result stp_psp_make_initial(stp_context* context, const stp_psp_points* points, uint32_t k,
                                stp_ellipse* ellipses, uint32_t* neighbours)
{
    stp_box box = stp_box_empty();
    for (size_t i = 0; i < points->count; ++i) {
        stp_box_add(&box, vector_at(points->positions, i));
    }
    float size = points->count > 0 ? stp_length(stp_sub(box.max, box.min)) : 0.0f;
    initial in = {.points = points,
                  .ellipses = ellipses,
                  .neighbours = neighbours,
                  .k = k,
                  .alone = size > 0.0f && size < HUGE_VALF ? 1e-3f * size : 1.0f};
    stp_result result =
        stp_find_nearest_points(context, points->positions, points->count, k, neighbours);
    if (result == STP_OK) {
        stp_parallel_for(context, points->count, 256, make_some, &in);
    }
    return result;
}
