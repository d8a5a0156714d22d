// SPDX-License-Identifier: MIT
#include "lod/cloud_candidates.h"

#include "base/math/color.h"
#include "base/splats/splat_columns.h"

#include <assert.h>
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
        if (out->light_normals != NULL) {
            memcpy(out->light_normals + 3 * to, &normal, sizeof(normal));
        }
        memcpy(out->colors + 4 * to, set->colors != NULL ? set->colors + 4 * i : p->base_color, 4);
        out->materials[to] = set->material;
    }
}

static void place_set(placing* p)
{
    const stp_point_set* set = &p->scene->point_sets[p->part->part.index];
    assert(set->material < p->scene->material_count);
    const stp_material* material = &p->scene->materials[set->material];
    for (int i = 0; i < 3; ++i) {
        p->base_color[i] = stp_linear_to_srgb8(material->base_color[i]);
    }
    p->base_color[3] = 255;
    stp_affine_normal_matrix(&p->part->transform, p->normal_matrix);
    stp_parallel_for(p->scene->context, set->point_count, GRAIN, place_points, p);
    p->first += set->point_count;
}

bool stp_sources_have_normals(const stp_scene* scene, const stp_source_list* list)
{
    for (size_t i = 0; i < list->part_count; ++i) {
        assert(list->parts[i].part.kind == STP_PART_POINTS);
        if (scene->point_sets[list->parts[i].part.index].normals == NULL) {
            return false;
        }
    }
    return true;
}

// Box around the splats of a set's prefix, in the captured space; a rotation enlarges it.
static stp_boxd box_of_set(const stp_placed_set* set)
{
    assert(set->prefix <= set->splats->count);
    stp_boxd box = stp_boxd_empty();
    for (uint32_t i = 0; i < set->prefix; ++i) {
        stp_boxd_add(&box, stp_splat_place(set->splats, i));
    }
    return stp_affine_box(&set->transform, box);
}

static stp_result count_points(const stp_scene* scene, const stp_source_list* list, uint64_t* count,
                               stp_vec3d* middle)
{
    stp_boxd box = stp_boxd_empty();
    *count = 0;
    for (size_t i = 0; i < list->part_count; ++i) {
        const stp_placed_part* part = &list->parts[i];
        assert(part->part.kind == STP_PART_POINTS);
        const stp_point_set* set = &scene->point_sets[part->part.index];
        stp_boxd local = {stp_to_double(set->bounds.min), stp_to_double(set->bounds.max)};
        stp_boxd placed = stp_affine_box(&part->transform, local);
        stp_boxd_add(&box, placed.min);
        stp_boxd_add(&box, placed.max);
        *count += set->point_count;
    }
    for (size_t i = 0; i < list->set_count; ++i) {
        stp_boxd placed = box_of_set(&list->sets[i]);
        stp_boxd_add(&box, placed.min);
        stp_boxd_add(&box, placed.max);
        *count += list->sets[i].prefix;
    }
    if (*count >= STP_NONE) {
        return stp_fail(scene->context, STP_ERROR_LIMIT,
                        "the scene has %llu points, more than one splat set can hold",
                        (unsigned long long)*count);
    }
    *middle = stp_scaled(stp_addd(box.min, box.max), 0.5);
    return STP_OK;
}

// Attributes that any source has.
static uint32_t find_attributes(const stp_scene* scene, const stp_source_list* list)
{
    uint32_t mask = 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        bool any = false;
        for (size_t i = 0; i < list->part_count && !any; ++i) {
            any = scene->point_sets[list->parts[i].part.index].attributes[a] != NULL;
        }
        for (size_t i = 0; i < list->set_count && !any; ++i) {
            any = list->sets[i].splats->attributes[a] != NULL;
        }
        mask |= any ? stp_attribute_bit((stp_attribute)a) : 0;
    }
    return mask;
}

// Copies values to their candidates; sources without the attribute have 0.
static size_t copy_values(const void* from, size_t count, size_t size, size_t first, void* to)
{
    if (from != NULL) {
        memcpy((unsigned char*)to + first * size, from, count * size);
    }
    return first + count;
}

// Points first, then the splats of sets: the order of the candidates.
static stp_result gather_attributes(const stp_scene* scene, const stp_source_list* list,
                                    size_t count, stp_candidates* candidates)
{
    uint32_t mask = find_attributes(scene, list);
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        size_t size = stp_attribute_size((stp_attribute)a), first = 0;
        if ((mask & stp_attribute_bit((stp_attribute)a)) == 0) {
            continue;
        }
        void* column = stp_alloc_zeroed(scene->context, count, size);
        if (column == NULL) {
            return stp_fail_memory(scene->context);
        }
        candidates->attributes[a] = column;
        for (size_t i = 0; i < list->part_count; ++i) {
            const stp_point_set* set = &scene->point_sets[list->parts[i].part.index];
            first = copy_values(set->attributes[a], set->point_count, size, first, column);
        }
        for (size_t i = 0; i < list->set_count; ++i) {
            const stp_placed_set* set = &list->sets[i];
            first = copy_values(set->splats->attributes[a], set->prefix, size, first, column);
        }
        assert(first == count && "a value for each candidate");
    }
    return STP_OK;
}

static bool has_lights(const stp_source_list* list)
{
    bool any = false;
    for (size_t i = 0; i < list->set_count && !any; ++i) {
        any = list->sets[i].splats->light_octaves != 0;
    }
    return any;
}

static stp_result allocate(stp_context* context, size_t count, bool lights,
                           stp_candidates* candidates)
{
    candidates->positions = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->normals = STP_NEW_ARRAY(context, float, 3 * count);
    candidates->light_normals = lights ? STP_NEW_ARRAY(context, float, 3 * count) : NULL;
    candidates->colors = STP_NEW_ARRAY(context, uint8_t, 4 * count);
    candidates->materials = STP_NEW_ARRAY(context, uint32_t, count);
    bool made = candidates->positions != NULL && candidates->normals != NULL &&
                candidates->colors != NULL && candidates->materials != NULL &&
                (candidates->light_normals != NULL || !lights);
    return made ? STP_OK : stp_fail_memory(context);
}

stp_result stp_candidates_of_cloud(const stp_scene* scene, const stp_source_list* list,
                                   bool has_normals, stp_candidates* candidates)
{
    *candidates = (stp_candidates){0};
    uint64_t count;
    stp_result result = count_points(scene, list, &count, &candidates->origin);
    if (result != STP_OK || count == 0) {
        return result;
    }
    result = allocate(scene->context, (size_t)count, has_lights(list), candidates);
    placing p = {.scene = scene, .candidates = candidates, .has_normals = has_normals};
    for (size_t i = 0; result == STP_OK && i < list->part_count; ++i) {
        p.part = &list->parts[i];
        place_set(&p);
    }
    candidates->count = (uint32_t)p.first;
    result = result == STP_OK ? gather_attributes(scene, list, (size_t)count, candidates) : result;
    if (result == STP_OK && list->set_count != 0) {
        result = stp_candidates_add_sets(scene->context, list->sets, list->set_count, candidates);
    }
    assert(result != STP_OK || candidates->count == count);
    if (result != STP_OK) {
        stp_candidates_destroy(scene->context, candidates);
    }
    return result;
}
