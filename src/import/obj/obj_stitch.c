// SPDX-License-Identifier: MIT
// Joins chunks: elements in file order, corners resolved, faces sorted by mesh.
#include "base/core/atomic_limits.h"
#include "import/obj/obj.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

// Where a chunk's elements start in the whole.
typedef struct chunk_base {
    size_t position, texcoord, normal, polygon;
} chunk_base;

typedef struct stitch {
    stp_obj* obj;
    chunk_base* bases;                ///< one more than chunks: the last holds the totals
    atomic_uint_fast64_t bad_polygon; ///< the first polygon of the file with an invalid index
    atomic_uint_fast64_t dropped;     ///< references to texture coordinates and normals
} stitch;

static void copy_items(void* target, size_t first, const stp_obj_array* array, size_t size)
{
    if (array->count != 0) {
        memcpy((unsigned char*)target + first * size, array->items, array->count * size);
    }
}

static void copy_chunk(stitch* s, size_t index)
{
    stp_obj* obj = s->obj;
    stp_obj_chunk* chunk = &obj->chunks[index];
    const chunk_base* base = &s->bases[index];
    assert(chunk->colors.count == 0 || chunk->colors.count == chunk->positions.count);
    copy_items(obj->positions, base->position, &chunk->positions, 3 * sizeof(float));
    copy_items(obj->texcoords, base->texcoord, &chunk->texcoords, 2 * sizeof(float));
    copy_items(obj->normals, base->normal, &chunk->normals, 3 * sizeof(float));
    if (obj->has_colors) {
        float* colors = obj->colors + 3 * base->position;
        for (size_t i = 3 * chunk->colors.count; i < 3 * chunk->positions.count; ++i) {
            colors[i] = STP_OBJ_NO_COLOR;
        }
        copy_items(obj->colors, base->position, &chunk->colors, 3 * sizeof(float));
    }
    stp_obj_array* done[] = {&chunk->positions, &chunk->texcoords, &chunk->normals, &chunk->colors};
    for (size_t i = 0; i < sizeof(done) / sizeof(done[0]); ++i) {
        if (!chunk->in_scratch) {
            stp_free(obj->context, done[i]->items);
        }
        done[i]->items = NULL;
    }
}

static void copy_chunks(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        copy_chunk(user, i);
    }
}

static stp_result join_elements(stitch* s)
{
    stp_obj* obj = s->obj;
    chunk_base sum = {0};
    float color_max = 0.0f;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        const stp_obj_chunk* chunk = &obj->chunks[i];
        s->bases[i] = sum;
        sum.position += chunk->positions.count;
        sum.texcoord += chunk->texcoords.count;
        sum.normal += chunk->normals.count;
        sum.polygon += chunk->polygons.count;
        obj->has_colors |= chunk->colors.count != 0;
        color_max = chunk->color_max > color_max ? chunk->color_max : color_max;
    }
    assert(sum.polygon == obj->polygon_count && "runs hold all polygons");
    s->bases[obj->chunk_count] = sum;
    obj->position_count = sum.position;
    obj->texcoord_count = sum.texcoord;
    obj->normal_count = sum.normal;
    obj->color_scale = color_max > 1.0f ? 1.0f / 255.0f : 1.0f;
    if (sum.position > STP_OBJ_INDEX_LIMIT || sum.texcoord > STP_OBJ_INDEX_LIMIT ||
        sum.normal > STP_OBJ_INDEX_LIMIT) {
        return stp_fail(obj->context, STP_ERROR_LIMIT, "%s: has more than 2^30 elements of a kind",
                        obj->import->path);
    }
    obj->positions = stp_obj_alloc(obj, sum.position, 3 * sizeof(float));
    obj->texcoords = stp_obj_alloc(obj, sum.texcoord, 2 * sizeof(float));
    obj->normals = stp_obj_alloc(obj, sum.normal, 3 * sizeof(float));
    obj->colors = obj->has_colors ? stp_obj_alloc(obj, sum.position, 3 * sizeof(float)) : NULL;
    if (obj->positions == NULL || obj->texcoords == NULL || obj->normals == NULL ||
        (obj->has_colors && obj->colors == NULL)) {
        return stp_obj_no_room(obj);
    }
    stp_parallel_for(obj->context, obj->chunk_count, 1, copy_chunks, s);
    return STP_OK;
}

// The group of a name; groups are children of the object they were written in.
static stp_result find_group(stp_obj* obj, const char* name, uint32_t parent, uint32_t* group)
{
    stp_hash key = stp_hash_bytes((stp_hash){.low = parent}, name, strlen(name));
    uint32_t fresh = (uint32_t)obj->groups.count;
    stp_result result = stp_lookup_add(&obj->group_names, &key, sizeof(key), fresh, group);
    if (result != STP_OK || *group != fresh) {
        return result;
    }
    stp_obj_group* made = stp_obj_grow(obj->context, &obj->groups, 1, sizeof(stp_obj_group));
    if (made == NULL) {
        return stp_fail_memory(obj->context);
    }
    *made = (stp_obj_group){.name = name, .parent = parent, .object = STP_NONE};
    obj->groups.count += 1;
    return STP_OK;
}

static stp_result find_material(stp_obj* obj, const char* name, uint32_t* material)
{
    *material = stp_lookup_find(&obj->material_names, name, strlen(name), STP_NONE);
    if (*material != STP_NONE) {
        return STP_OK;
    }
    stp_material made = stp_material_plain();
    made.name = name[0] != '\0' ? name : NULL;
    if (made.name != NULL) {
        obj->unknown_material = obj->unknown_count == 0 ? name : obj->unknown_material;
        obj->unknown_count += 1;
    }
    uint32_t index;
    stp_result result = stp_scene_add_material(obj->import->scene, &made, &index);
    return result == STP_OK
               ? stp_lookup_add(&obj->material_names, name, strlen(name), index, material)
               : result;
}

static stp_result find_mesh(stp_obj* obj, uint32_t group, uint32_t material, uint32_t* mesh)
{
    uint32_t key[2] = {group, material};
    uint32_t fresh = (uint32_t)obj->meshes.count;
    stp_result result = stp_lookup_add(&obj->mesh_keys, key, sizeof(key), fresh, mesh);
    if (result != STP_OK || *mesh != fresh) {
        return result;
    }
    stp_obj_mesh* made = stp_obj_grow(obj->context, &obj->meshes, 1, sizeof(stp_obj_mesh));
    if (made == NULL) {
        return stp_fail_memory(obj->context);
    }
    *made = (stp_obj_mesh){.group = group, .material = material};
    obj->meshes.count += 1;
    return STP_OK;
}

// State for the faces read next.
typedef struct cursor {
    uint32_t object, group; ///< STP_NONE: none
    uint32_t material;      ///< STP_NONE: none named yet
} cursor;

static stp_result add_run(stp_obj* obj, const cursor* at, uint32_t chunk_index, size_t begin,
                          size_t end)
{
    assert(begin <= end && end <= obj->chunks[chunk_index].polygons.count);
    if (begin == end) {
        return STP_OK;
    }
    const stp_obj_chunk* chunk = &obj->chunks[chunk_index];
    const uint32_t* ends = chunk->polygons.items;
    stp_obj_run run = {.chunk = chunk_index, .polygon = begin, .polygon_count = end - begin};
    run.corner = begin > 0 ? ends[begin - 1] : 0;
    run.corner_count = ends[end - 1] - run.corner;
    assert(run.corner_count >= 3 * run.polygon_count && "smaller faces were left out");
    uint32_t material = at->material, group = at->group != STP_NONE ? at->group : at->object;
    stp_result result = STP_OK;
    if (material == STP_NONE) {
        result = find_material(obj, "", &material);
    }
    if (result == STP_OK && group == STP_NONE) {
        result = find_group(obj, "", STP_NONE, &group);
    }
    if (result == STP_OK) {
        result = find_mesh(obj, group, material, &run.mesh);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_obj_run* kept = stp_obj_grow(obj->context, &obj->runs, 1, sizeof(stp_obj_run));
    if (kept == NULL) {
        return stp_fail_memory(obj->context);
    }
    *kept = run;
    obj->runs.count += 1;
    return STP_OK;
}

static stp_result apply_event(stp_obj* obj, const stp_obj_event* event, cursor* at)
{
    if (event->kind == STP_OBJ_LIBRARY) {
        return STP_OK;
    }
    const char* name =
        stp_arena_copy_text(&obj->import->scene->text, (const char*)event->text, event->length);
    if (name == NULL) {
        return stp_fail_memory(obj->context);
    }
    if (event->kind == STP_OBJ_MATERIAL) {
        return find_material(obj, name, &at->material);
    }
    at->group = STP_NONE;
    at->object = event->kind == STP_OBJ_OBJECT ? STP_NONE : at->object;
    if (name[0] == '\0') {
        return STP_OK; // without a name, it ends the previous one
    }
    return event->kind == STP_OBJ_OBJECT ? find_group(obj, name, STP_NONE, &at->object)
                                         : find_group(obj, name, at->object, &at->group);
}

static void warn_of_materials(const stp_obj* obj)
{
    if (obj->unknown_count > 0) {
        stp_warn(obj->context, "%s: no library defines the material \"%.200s\"%s",
                 obj->import->path, obj->unknown_material,
                 obj->unknown_count > 1 ? " and others" : "");
    }
}

static stp_result make_runs(stp_obj* obj)
{
    cursor at = {STP_NONE, STP_NONE, STP_NONE};
    stp_result result = STP_OK;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        const stp_obj_chunk* chunk = &obj->chunks[i];
        const stp_obj_event* events = chunk->events.items;
        size_t polygon = 0;
        for (size_t k = 0; k < chunk->events.count && result == STP_OK; ++k) {
            result = add_run(obj, &at, (uint32_t)i, polygon, events[k].polygon);
            polygon = events[k].polygon;
            result = result == STP_OK ? apply_event(obj, &events[k], &at) : result;
        }
        if (result == STP_OK) {
            result = add_run(obj, &at, (uint32_t)i, polygon, chunk->polygons.count);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

// Assigns positions to all runs, so that each mesh's faces are contiguous in file order.
static stp_result place_runs(stp_obj* obj)
{
    stp_obj_run* runs = obj->runs.items;
    stp_obj_mesh* meshes = obj->meshes.items;
    for (size_t i = 0; i < obj->runs.count; ++i) {
        meshes[runs[i].mesh].corner_count += runs[i].corner_count;
        meshes[runs[i].mesh].polygon_count += runs[i].polygon_count;
    }
    for (size_t i = 0; i < obj->meshes.count; ++i) {
        meshes[i].first_corner = obj->corner_count;
        meshes[i].first_polygon = obj->polygon_count;
        obj->corner_count += meshes[i].corner_count;
        obj->polygon_count += meshes[i].polygon_count;
        if (meshes[i].corner_count > UINT32_MAX) {
            return stp_fail(obj->context, STP_ERROR_LIMIT, "%s: a mesh has more than 2^32 corners",
                            obj->import->path);
        }
        meshes[i].corner_count = meshes[i].polygon_count = 0;
    }
    for (size_t i = 0; i < obj->runs.count; ++i) {
        stp_obj_mesh* mesh = &meshes[runs[i].mesh];
        runs[i].target_corner = mesh->first_corner + mesh->corner_count;
        runs[i].target_polygon = mesh->first_polygon + mesh->polygon_count;
        mesh->corner_count += runs[i].corner_count;
        mesh->polygon_count += runs[i].polygon_count;
    }
    assert(obj->corner_count >= 3 * obj->polygon_count);
    obj->corners = stp_obj_alloc(obj, obj->corner_count, sizeof(stp_obj_corner));
    obj->polygons = stp_obj_alloc(obj, obj->polygon_count, sizeof(uint32_t));
    return obj->corners != NULL && obj->polygons != NULL ? STP_OK : stp_obj_no_room(obj);
}

// The absolute index. STP_OBJ_ABSENT if `index` is; also, with *good false, if it does not exist.
static uint32_t resolve(uint32_t index, size_t base, size_t count, bool* good)
{
    if (index == STP_OBJ_ABSENT) {
        return index;
    }
    int64_t absolute = (index & STP_OBJ_RELATIVE) != 0
                           ? (int64_t)base + ((int64_t)index - (int64_t)STP_OBJ_RELATIVE_ZERO)
                           : (int64_t)index;
    bool exists = absolute >= 0 && absolute < (int64_t)count;
    *good = *good && exists;
    return exists ? (uint32_t)absolute : STP_OBJ_ABSENT;
}

static void resolve_run(stitch* s, const stp_obj_run* run)
{
    stp_obj* obj = s->obj;
    const stp_obj_chunk* chunk = &obj->chunks[run->chunk];
    const chunk_base* base = &s->bases[run->chunk];
    const stp_obj_corner* corners = (const stp_obj_corner*)chunk->corners.items + run->corner;
    const uint32_t* ends = (const uint32_t*)chunk->polygons.items + run->polygon;
    const stp_obj_mesh* mesh = (const stp_obj_mesh*)obj->meshes.items + run->mesh;
    stp_obj_corner* out = obj->corners + run->target_corner;
    size_t shift =
        run->target_corner - mesh->first_corner - run->corner; // may wrap, and wraps back
    uint64_t dropped = 0;
    for (size_t polygon = 0, corner = 0; polygon < run->polygon_count; ++polygon) {
        bool good = true;
        for (; corner < ends[polygon] - run->corner; ++corner) {
            const stp_obj_corner* in = &corners[corner];
            bool here = in->position != STP_OBJ_ABSENT, has_texcoord = true, has_normal = true;
            out[corner].position =
                resolve(in->position, base->position, obj->position_count, &here);
            out[corner].texcoord =
                resolve(in->texcoord, base->texcoord, obj->texcoord_count, &has_texcoord);
            out[corner].normal = resolve(in->normal, base->normal, obj->normal_count, &has_normal);
            dropped += (uint64_t)!has_texcoord + (uint64_t)!has_normal;
            good = good && here;
        }
        if (!good) {
            stp_atomic_min(&s->bad_polygon, base->polygon + run->polygon + polygon);
        }
        obj->polygons[run->target_polygon + polygon] = (uint32_t)(ends[polygon] + shift);
        assert(corner == ends[polygon] - run->corner && corner <= run->corner_count);
    }
    if (dropped > 0) {
        atomic_fetch_add(&s->dropped, dropped);
    }
}

static void resolve_runs(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stitch* s = user;
    for (size_t i = begin; i < end; ++i) {
        resolve_run(s, (const stp_obj_run*)s->obj->runs.items + i);
    }
}

static stp_result resolve_corners(stitch* s)
{
    stp_obj* obj = s->obj;
    atomic_store(&s->bad_polygon, SIZE_MAX);
    atomic_store(&s->dropped, 0);
    stp_parallel_for(obj->context, obj->runs.count, 1 + obj->runs.count / 4096, resolve_runs, s);
    size_t bad = atomic_load(&s->bad_polygon);
    if (bad != SIZE_MAX) {
        return stp_fail(
            obj->context, STP_ERROR_FORMAT,
            "%s: face %llu: refers to a position that does not exist (the file has %llu)",
            obj->import->path, (unsigned long long)bad + 1,
            (unsigned long long)obj->position_count);
    }
    uint64_t dropped = atomic_load(&s->dropped);
    if (dropped > 0) {
        stp_warn(obj->context,
                 "%s: %llu references of corners to texture coordinates and normals that do not "
                 "exist are left out (the file has %llu and %llu)",
                 obj->import->path, (unsigned long long)dropped,
                 (unsigned long long)obj->texcoord_count, (unsigned long long)obj->normal_count);
    }
    return STP_OK;
}

static stp_result join_points(stitch* s)
{
    stp_obj* obj = s->obj;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        obj->point_count += obj->chunks[i].points.count;
    }
    obj->points = stp_obj_alloc(obj, obj->point_count, sizeof(uint32_t));
    if (obj->points == NULL) {
        return stp_obj_no_room(obj);
    }
    bool good = true;
    size_t target = 0;
    for (size_t i = 0; i < obj->chunk_count; ++i) {
        const uint32_t* points = obj->chunks[i].points.items;
        for (size_t k = 0; k < obj->chunks[i].points.count; ++k) {
            good = good && points[k] != STP_OBJ_ABSENT;
            obj->points[target++] =
                resolve(points[k], s->bases[i].position, obj->position_count, &good);
        }
    }
    assert(target == obj->point_count);
    return good ? STP_OK
                : stp_fail(
                      obj->context, STP_ERROR_FORMAT,
                      "%s: a point refers to a position that does not exist (the file has %llu)",
                      obj->import->path, (unsigned long long)obj->position_count);
}

stp_result stp_obj_stitch(stp_obj* obj)
{
    stitch s = {.obj = obj, .bases = STP_NEW_ARRAY(obj->context, chunk_base, obj->chunk_count + 1)};
    stp_result result = s.bases != NULL ? make_runs(obj) : stp_fail_memory(obj->context);
    if (result == STP_OK) {
        warn_of_materials(obj);
        result = place_runs(obj);
    }
    if (result == STP_OK) {
        result = join_elements(&s);
    }
    if (result == STP_OK) {
        result = resolve_corners(&s);
    }
    if (result == STP_OK) {
        result = join_points(&s);
    }
    stp_free(obj->context, s.bases);
    return result;
}
