// SPDX-License-Identifier: MIT
#include "import/reading/point_columns.h"

#include "scene/bulk.h"

#include <assert.h>

/// Reciprocal share of the scene's memory: larger point sets go directly to its spill file
#define SHARE 2

bool stp_points_go_to_spill(const stp_scene* scene, uint64_t bytes)
{
    return scene->spill != NULL &&
           (bytes > scene->spill_above / SHARE || scene->bulk_bytes + bytes > scene->spill_above);
}

static void size_columns(const stp_point_columns_desc* desc,
                         stp_bulk_array arrays[STP_POINT_ARRAYS])
{
    size_t count = desc->point_count;
    arrays[0] = (stp_bulk_array){.size = count * 3 * sizeof(float)};
    arrays[1] = (stp_bulk_array){.size = desc->normals ? count * 3 * sizeof(float) : 0};
    arrays[2] = (stp_bulk_array){.size = desc->colors ? count * 4 : 0};
    for (unsigned i = 0; i < STP_ATTRIBUTES; ++i) {
        size_t size = desc->attributes >> i & 1 ? stp_attribute_size((stp_attribute)i) : 0;
        arrays[STP_POINT_ATTRIBUTE_ARRAY + i] = (stp_bulk_array){.size = count * size};
    }
}

stp_result stp_point_columns_create(stp_import* import, const stp_point_columns_desc* desc,
                                    stp_point_set* set)
{
    stp_scene* scene = import->scene;
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    uint64_t bytes = 0;
    assert(desc->attributes >> STP_ATTRIBUTES == 0 && "a bit per attribute");
    size_columns(desc, arrays);
    for (int i = 0; i < STP_POINT_ARRAYS; ++i) {
        bytes += arrays[i].size;
    }
    *set = (stp_point_set){.spilled = stp_points_go_to_spill(scene, bytes)};
    stp_result result = STP_OK;
    if (set->spilled) {
        result = stp_bulk_alloc_spilled(scene->spill, arrays, STP_POINT_ARRAYS);
    }
    for (int i = 0; i < STP_POINT_ARRAYS && !set->spilled && result == STP_OK; ++i) {
        bool wanted = i == 0 || arrays[i].size > 0;
        arrays[i].bytes = wanted ? stp_alloc(import->context, arrays[i].size) : NULL;
        result = wanted && arrays[i].bytes == NULL ? stp_fail_memory(import->context) : STP_OK;
    }
    stp_points_set_arrays(set, arrays);
    if (result != STP_OK) {
        stp_point_columns_free(import, set);
        return result;
    }
    assert(!desc->normals || set->normals != NULL || desc->point_count == 0);
    assert(!desc->colors || set->colors != NULL || desc->point_count == 0);
    set->point_count = desc->point_count;
    return STP_OK;
}

void stp_point_columns_free(stp_import* import, stp_point_set* set)
{
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    stp_points_get_arrays(set, arrays);
    for (int i = 0; i < STP_POINT_ARRAYS && !set->spilled; ++i) {
        stp_free(import->context, arrays[i].bytes);
    }
    *set = (stp_point_set){0};
}

stp_result stp_point_columns_add(stp_import* import, stp_point_set* set)
{
    stp_part part = {.kind = STP_PART_POINTS};
    assert(import->root < import->scene->object_count && "parts belong to the last object");
    stp_point_columns_release(import, set);
    stp_result result = set->spilled ? stp_scene_add_spilled_points(import->scene, set, &part.index)
                                     : stp_scene_add_point_set(import->scene, set, &part.index);
    *set = (stp_point_set){0};
    return result == STP_OK ? stp_scene_add_part(import->scene, part) : result;
}

void stp_point_columns_release(stp_import* import, const stp_point_set* set)
{
    if (set->spilled) {
        assert(import->scene->spill != NULL && "spilled sets live in it");
        if (!import->alone) { // mapped
            stp_file_evict(&import->file);
        }
        stp_spill_release_pages(import->scene->spill);
    }
}

void stp_import_set_origin(stp_import* import, const double origin[3])
{
    assert(import->root < import->scene->object_count);
    stp_affine* placed = &import->scene->objects[import->root].transform;
    stp_affine shift = stp_affine_identity();
    for (int i = 0; i < 3; ++i) {
        shift.m[i][3] = origin[i];
    }
    *placed = stp_affine_multiply(*placed, shift);
}
