// SPDX-License-Identifier: MIT
#include "lod/points.h"

#include "base/color.h"

#include <string.h>

#define GRAIN 16384

typedef struct placing {
    const stp_scene* scene;
    const stp_placed_part* part;
    stp_candidates* candidates;
    size_t first; ///< candidate of the set's first point
    uint8_t base_color[4];
    double normal_matrix[3][3];
    bool has_normals;
} placing;

static void place_points(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const placing* p = user;
    const stp_point_set* set = &p->scene->point_sets[p->part->part.index];
    stp_candidates* out = p->candidates;
    for (size_t i = begin; i < end; ++i) {
        const float* from = set->positions + 3 * i;
        stp_vec3d at = stp_affine_point(
            &p->part->transform, (stp_vec3d){(double)from[0], (double)from[1], (double)from[2]});
        stp_vec3 place = stp_to_float(stp_subd(at, out->origin)), normal = {0, 1, 0};
        if (p->has_normals) {
            const float* n = set->normals + 3 * i;
            double x = (double)n[0], y = (double)n[1], z = (double)n[2];
            const double(*m)[3] = p->normal_matrix;
            stp_vec3d turned = stp_normalized((stp_vec3d){m[0][0] * x + m[0][1] * y + m[0][2] * z,
                                                          m[1][0] * x + m[1][1] * y + m[1][2] * z,
                                                          m[2][0] * x + m[2][1] * y + m[2][2] * z});
            normal = stp_dotd(turned, turned) > 0.0 ? stp_to_float(turned) : normal;
        }
        size_t to = p->first + i;
        memcpy(out->positions + 3 * to, &place, sizeof(place));
        memcpy(out->normals + 3 * to, &normal, sizeof(normal));
        memcpy(out->colors + 4 * to, set->colors != NULL ? set->colors + 4 * i : p->base_color, 4);
        out->materials[to] = set->material;
    }
}

static void place_set(placing* p)
{
    const stp_point_set* set = &p->scene->point_sets[p->part->part.index];
    const stp_material* material = &p->scene->materials[set->material];
    for (int i = 0; i < 3; ++i) {
        p->base_color[i] = stp_linear_to_srgb8(material->base_color[i]);
    }
    p->base_color[3] = 255;
    stp_affine_normal_matrix(&p->part->transform, p->normal_matrix);
    stp_parallel_for(p->scene->context, set->point_count, GRAIN, place_points, p);
    p->first += set->point_count;
}

static stp_result count_points(const stp_scene* scene, const stp_placed_part* parts,
                               size_t part_count, stp_candidates* candidates, bool* has_normals)
{
    uint64_t count = 0;
    stp_boxd box = stp_boxd_empty();
    *has_normals = true;
    for (size_t i = 0; i < part_count; ++i) {
        const stp_point_set* set = &scene->point_sets[parts[i].part.index];
        stp_boxd local = {stp_to_double(set->bounds.min), stp_to_double(set->bounds.max)};
        stp_boxd placed = stp_affine_box(&parts[i].transform, local);
        stp_boxd_add(&box, placed.min);
        stp_boxd_add(&box, placed.max);
        count += set->point_count;
        *has_normals = *has_normals && set->normals != NULL;
    }
    if (count >= STP_NONE) {
        return stp_fail(scene->context, STP_ERROR_LIMIT,
                        "the scene has %llu points, more than one set of surfels can hold",
                        (unsigned long long)count);
    }
    candidates->count = (uint32_t)count;
    candidates->origin = stp_scaled(stp_addd(box.min, box.max), 0.5);
    return STP_OK;
}

stp_result stp_candidates_from_points(const stp_scene* scene, const stp_placed_part* parts,
                                      size_t part_count, stp_candidates* candidates,
                                      bool* has_normals)
{
    stp_context* context = scene->context;
    *candidates = (stp_candidates){0};
    stp_result result = count_points(scene, parts, part_count, candidates, has_normals);
    if (result != STP_OK) {
        return result;
    }
    size_t count = candidates->count;
    candidates->positions = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->normals = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->colors = STP_NEW_ARRAY(context, uint8_t, 4 * count);
    candidates->materials = STP_NEW_ARRAY(context, uint32_t, count);
    if (candidates->positions == NULL || candidates->normals == NULL ||
        candidates->colors == NULL || candidates->materials == NULL) {
        stp_candidates_destroy(context, candidates);
        return stp_fail_memory(context);
    }
    placing p = {.scene = scene, .candidates = candidates, .has_normals = *has_normals};
    for (size_t i = 0; i < part_count; ++i) {
        p.part = &parts[i];
        place_set(&p);
    }
    return STP_OK;
}
