// SPDX-License-Identifier: MIT
#include "lod/psp/initial.h"

#include "lod/psp/kd_tree.h"

#include <assert.h>

/// Normal of the least-squares plane of a point and its neighbours.
static stp_vec3 find_normal(const stp_kd_tree* tree, stp_vec3 p, const uint32_t* places,
                            uint32_t count, stp_vec3 given)
{
    double sum[3] = {0}, m[6] = {0};
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 q = stp_sub(stp_kd_at(tree, places[i]), p);
        double x = (double)q.x, y = (double)q.y, z = (double)q.z;
        sum[0] += x;
        sum[1] += y;
        sum[2] += z;
        m[0] += x * x;
        m[1] += x * y;
        m[2] += x * z;
        m[3] += y * y;
        m[4] += y * z;
        m[5] += z * z;
    }
    double share = 1.0 / ((double)count + 1.0);
    for (int a = 0, at = 0; a < 3; ++a) {
        for (int b = a; b < 3; ++b) {
            m[at++] -= sum[a] * sum[b] * share;
        }
    }
    if (!(m[0] + m[3] + m[5] > 0.0) && stp_dot(given, given) > 0.0f) {
        return stp_normalize(given); // all points coincide
    }
    stp_vec3 n = stp_normalize(stp_to_float(stp_scatter_normal(m)));
    float side = stp_dot(n, given);
    if (side == 0.0f) {
        float x = fabsf(n.x), y = fabsf(n.y), z = fabsf(n.z);
        side = x >= y && x >= z ? n.x : y >= z ? n.y : n.z;
    }
    return side < 0.0f ? stp_scale(n, -1.0f) : n;
}

stp_ellipse stp_psp_initial_splat(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                                  uint32_t count, stp_vec3 given, float alone)
{
    assert(count <= STP_NEIGHBOURS_MAX && alone > 0.0f);
    stp_vec3 p = stp_kd_at(tree, place), n = find_normal(tree, p, places, count, given);
    float square = 0.0f;
    for (uint32_t i = 0; i < count; ++i) {
        stp_vec3 d = stp_sub(stp_kd_at(tree, places[i]), p);
        d = stp_sub(d, stp_scale(n, stp_dot(d, n)));
        square = stp_max(square, stp_dot(d, d));
    }
    float radius = sqrtf(square);
    return stp_ellipse_cover(p, n, NULL, 0, radius > 0.0f ? radius : alone);
}

float stp_psp_radius_alone(float size)
{
    return size > 0.0f && size < HUGE_VALF ? 1e-3f * size : 1.0f;
}

typedef struct initial {
    const stp_psp_points* points;
    const stp_kd_tree* tree;
    stp_ellipse* ellipses;
    uint32_t* neighbours;
    uint32_t k;
    float alone;
} initial;

static void make_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const initial* in = user;
    stp_kd_path path = {.leaf = UINT32_MAX};
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        uint32_t place = (uint32_t)i, places[STP_NEIGHBOURS_MAX];
        uint32_t count = stp_kd_nearest(in->tree, &path, place, in->k, places);
        uint32_t point = stp_kd_index(in->tree, place);
        const float* n =
            in->points->normals != NULL ? in->points->normals + 3 * (size_t)point : NULL;
        stp_vec3 given = n != NULL ? (stp_vec3){n[0], n[1], n[2]} : (stp_vec3){0};
        given = stp_is_finite(given) ? given : (stp_vec3){0};
        in->ellipses[point] =
            stp_psp_initial_splat(in->tree, place, places, count, given, in->alone);
        stp_list_neighbours(in->tree, place, places, count, in->k,
                            in->neighbours + (size_t)in->k * point);
    }
}

stp_result stp_psp_make_initial(stp_context* context, const stp_psp_points* points, uint32_t k,
                                stp_ellipse* ellipses, uint32_t* neighbours)
{
    assert(k > 0 && k <= STP_NEIGHBOURS_MAX);
    stp_kd_tree tree;
    stp_result result = stp_kd_tree_make(context, points->positions, points->count, 1.0f, &tree);
    if (result == STP_OK) {
        stp_box box = stp_kd_box(&tree);
        float size = points->count > 0 ? stp_length(stp_sub(box.max, box.min)) : 0.0f;
        initial in = {points, &tree, ellipses, neighbours, k, stp_psp_radius_alone(size)};
        stp_parallel_for(context, points->count, 1024, make_some, &in);
    }
    stp_kd_tree_destroy(context, &tree);
    return result;
}
