// SPDX-License-Identifier: MIT
#include "import/reading/point_columns.h"

#include "scene/bulk.h"

#include <assert.h>
#include <math.h>
#include <stdatomic.h>

#define FAR 4096.0                 ///< coordinates up to here keep their digits as floats
#define ROUND 1024.0               ///< origins are multiples of this
#define GRAIN ((size_t)1 << 16)    ///< points
#define RELEASE_EVERY ((size_t)64) ///< tasks, after which pages are released
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

// Times of a set, some of which may be invalid.
typedef struct time_check {
    stp_import* import;
    const stp_point_set* set;
    atomic_uint_fast64_t invalid;
} time_check;

static void check_run(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    time_check* c = user;
    double* times = c->set->attributes[STP_ATTRIBUTE_TIME];
    uint64_t invalid = 0;
    assert(end <= c->set->point_count);
    for (size_t i = begin; i < end; ++i) {
        if (!(fabs(times[i]) <= STP_SCENE_TIME_LIMIT)) { // also NaN
            times[i] = 0.0;
            invalid += 1;
        }
    }
    if (invalid > 0) {
        atomic_fetch_add_explicit(&c->invalid, invalid, memory_order_relaxed);
    }
    if (begin / GRAIN % RELEASE_EVERY == RELEASE_EVERY - 1) {
        stp_point_columns_release(c->import, c->set);
    }
}

// A file cannot hold times that are not finite or far too large, and they are no reason to lose
// points. Other attributes are whole numbers.
static void check_times(stp_import* import, stp_point_set* set)
{
    void** column = &set->attributes[STP_ATTRIBUTE_TIME];
    if (*column == NULL) {
        return;
    }
    time_check c = {.import = import, .set = set};
    atomic_init(&c.invalid, 0);
    stp_parallel_for(import->context, set->point_count, GRAIN, check_run, &c);
    uint64_t invalid = atomic_load(&c.invalid);
    assert(invalid <= set->point_count);
    stp_losses_add(&import->losses, STP_LOSS_TIME, invalid);
    if (invalid > 0 && invalid == set->point_count) { // none was recorded
        if (!set->spilled) {
            stp_free(import->context, *column);
        }
        *column = NULL;
    }
}

stp_result stp_point_columns_add(stp_import* import, stp_point_set* set)
{
    stp_part part = {.kind = STP_PART_POINTS};
    assert(import->root < import->scene->object_count && "parts belong to the last object");
    check_times(import, set);
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

void stp_import_choose_origin(const double place[3], double origin[3])
{
    for (int i = 0; i < 3; ++i) {
        bool far = fabs(place[i]) >= FAR && fabs(place[i]) < 1e15;
        origin[i] = far ? (double)(int64_t)(place[i] / ROUND) * ROUND : 0.0;
        assert(!far || fabs(place[i] - origin[i]) < ROUND);
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
