// SPDX-License-Identifier: MIT
// Adds groups, meshes and points of an OBJ file to the scene.
#include "import/obj/obj.h"
#include "import/reading/smooth.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <stdatomic.h>
#include <string.h>

typedef struct build {
    stp_obj* obj;
    stp_mesh* built; ///< one for each of obj->meshes
    uint32_t* first; ///< per group: its first mesh; STP_NONE: none
    uint32_t* next;  ///< per mesh: the next one of its group; STP_NONE: none
    bool* needed;    ///< whether a group has meshes, or one below it has
    atomic_bool out_of_memory;
} build;

static void build_small_meshes(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    build* all = user;
    const stp_obj_mesh* meshes = all->obj->meshes.items;
    for (size_t i = begin; i < end; ++i) {
        if (meshes[i].corner_count <= STP_OBJ_SMALL_MESH &&
            stp_obj_build_mesh(all->obj, &meshes[i], &all->built[i]) != STP_OK) {
            atomic_store(&all->out_of_memory, true);
        }
    }
}

static stp_result build_mesh(build* all, size_t index)
{
    stp_obj* obj = all->obj;
    const stp_obj_mesh* mesh = (const stp_obj_mesh*)obj->meshes.items + index;
    stp_result result = stp_obj_build_mesh(obj, mesh, &all->built[index]);
    return result == STP_ERROR_OUT_OF_MEMORY ? stp_fail_memory(obj->context) : result;
}

static stp_result build_meshes(build* all)
{
    stp_obj* obj = all->obj;
    const stp_obj_mesh* meshes = obj->meshes.items;
    for (size_t i = 0; i < obj->meshes.count; ++i) {
        stp_result result =
            meshes[i].corner_count > STP_OBJ_SMALL_MESH ? build_mesh(all, i) : STP_OK;
        if (result != STP_OK) {
            return result;
        }
    }
    stp_parallel_for(obj->context, obj->meshes.count, 1, build_small_meshes, all);
    return atomic_load(&all->out_of_memory) ? stp_fail_memory(obj->context) : STP_OK;
}

// Adds a group's meshes as parts of the last object.
static stp_result add_parts(build* all, size_t group)
{
    stp_scene* scene = all->obj->import->scene;
    stp_obj_group* groups = all->obj->groups.items;
    for (uint32_t i = all->first[group]; i != STP_NONE; i = all->next[i]) {
        // if the file does not fit in memory, neither may all its meshes
        stp_result built = all->obj->scratch != NULL ? build_mesh(all, i) : STP_OK;
        if (built != STP_OK) {
            return built;
        }
        stp_mesh mesh = all->built[i];
        all->built[i] = (stp_mesh){0};
        mesh.name = groups[group].name[0] != '\0' ? groups[group].name : NULL;
        stp_part part = {.kind = STP_PART_MESH};
        stp_result result = stp_import_add_mesh(all->obj->import, &mesh, &part.index);
        if (result == STP_OK) {
            result = stp_scene_add_part(scene, part);
        }
        if (result != STP_OK) {
            return result;
        }
    }
    return STP_OK;
}

// Whether the group is the file itself: content before any `o` or `g`.
static bool is_root(const stp_obj_group* group)
{
    return group->parent == STP_NONE && group->name[0] == '\0';
}

static stp_result add_group(build* all, size_t index)
{
    stp_import* import = all->obj->import;
    stp_obj_group* groups = all->obj->groups.items;
    stp_obj_group* group = &groups[index];
    uint32_t parent = group->parent != STP_NONE ? groups[group->parent].object : import->root;
    stp_object object = {.name = group->name, .parent = parent, .transform = stp_affine_identity()};
    stp_result result = stp_scene_add_object(import->scene, &object, &group->object);
    return result == STP_OK ? add_parts(all, index) : result;
}

static void link_groups(build* all)
{
    const stp_obj* obj = all->obj;
    const stp_obj_mesh* meshes = obj->meshes.items;
    const stp_obj_group* groups = obj->groups.items;
    memset(all->first, 0xff, obj->groups.count * sizeof(uint32_t));
    for (size_t i = obj->meshes.count; i-- > 0;) {
        assert(meshes[i].group < obj->groups.count);
        all->next[i] = all->first[meshes[i].group];
        all->first[meshes[i].group] = (uint32_t)i;
    }
    for (size_t i = obj->groups.count; i-- > 0;) { // those below come later in the list
        assert(groups[i].parent == STP_NONE || groups[i].parent < i);
        all->needed[i] = all->needed[i] || all->first[i] != STP_NONE;
        if (all->needed[i] && groups[i].parent != STP_NONE) {
            all->needed[groups[i].parent] = true;
        }
    }
}

static stp_result add_groups(build* all)
{
    const stp_obj* obj = all->obj;
    const stp_obj_group* groups = obj->groups.items;
    link_groups(all);
    stp_result result = STP_OK;
    for (size_t i = 0; i < obj->groups.count && result == STP_OK; ++i) {
        result =
            is_root(&groups[i]) ? add_parts(all, i) : STP_OK; // while the root is the last object
    }
    for (size_t i = 0; i < obj->groups.count && result == STP_OK; ++i) {
        result = all->needed[i] && !is_root(&groups[i]) ? add_group(all, i) : STP_OK;
    }
    return result;
}

// The positions used by `p`; all of them in a file without faces and points.
static stp_result add_points(stp_obj* obj)
{
    bool all = obj->point_count == 0;
    size_t count = all ? obj->position_count : obj->point_count;
    stp_point_set set = {.point_count = (uint32_t)count};
    bool normals = all && obj->normal_count == count;
    set.positions = STP_NEW_ARRAY(obj->context, float, 3 * count);
    set.normals = normals ? STP_NEW_ARRAY(obj->context, float, 3 * count) : NULL;
    set.colors = obj->has_colors ? STP_NEW_ARRAY(obj->context, uint8_t, 4 * count) : NULL;
    if (set.positions == NULL || normals != (set.normals != NULL) ||
        obj->has_colors != (set.colors != NULL)) {
        stp_free(obj->context, set.positions);
        stp_free(obj->context, set.normals);
        stp_free(obj->context, set.colors);
        return stp_fail_memory(obj->context);
    }
    for (size_t i = 0; i < count; ++i) {
        size_t p = all ? i : obj->points[i];
        assert(p < obj->position_count && "indices were checked");
        memcpy(set.positions + 3 * i, obj->positions + 3 * p, 3 * sizeof(float));
        if (normals) {
            const float* in = obj->normals + 3 * p;
            stp_vec3 normal = stp_normalize((stp_vec3){in[0], in[1], in[2]});
            memcpy(set.normals + 3 * i, &normal, sizeof(normal));
        }
        for (size_t k = 0; obj->has_colors && k < 4; ++k) {
            set.colors[4 * i + k] = k == 3 ? 255 : stp_unorm8(stp_obj_color(obj, 3 * p + k));
        }
    }
    stp_part part = {.kind = STP_PART_POINTS};
    stp_result result = stp_scene_add_point_set(obj->import->scene, &set, &part.index);
    return result == STP_OK ? stp_scene_add_part(obj->import->scene, part) : result;
}

stp_result stp_obj_build(stp_obj* obj)
{
    if (obj->meshes.count == 0 && obj->position_count == 0) {
        return stp_fail(obj->context, STP_ERROR_FORMAT, "%s: has no positions", obj->import->path);
    }
    assert(obj->meshes.count == 0 || obj->groups.count > 0);
    stp_affine* placed = &obj->import->scene->objects[obj->import->root].transform;
    stp_affine shift = stp_affine_identity();
    for (int i = 0; i < 3; ++i) {
        shift.m[i][3] = obj->origin[i];
    }
    *placed = stp_affine_multiply(*placed, shift);
    build all = {.obj = obj,
                 .built = STP_NEW_ZEROED(obj->context, stp_mesh, obj->meshes.count),
                 .first = STP_NEW_ARRAY(obj->context, uint32_t, obj->groups.count),
                 .next = STP_NEW_ARRAY(obj->context, uint32_t, obj->meshes.count),
                 .needed = STP_NEW_ZEROED(obj->context, bool, obj->groups.count)};
    atomic_init(&all.out_of_memory, false);
    bool ready = all.built != NULL && all.first != NULL && all.next != NULL && all.needed != NULL;
    stp_result result = ready ? STP_OK : stp_fail_memory(obj->context);
    if (result == STP_OK && obj->scratch == NULL) {
        result = build_meshes(&all);
    }
    if (result == STP_OK && (obj->point_count != 0 || obj->meshes.count == 0)) {
        result = add_points(obj);
    }
    if (result == STP_OK) {
        result = add_groups(&all);
    }
    for (size_t i = 0; all.built != NULL && i < obj->meshes.count; ++i) {
        stp_obj_free_mesh(obj->context, &all.built[i]);
    }
    stp_free(obj->context, all.built);
    stp_free(obj->context, all.first);
    stp_free(obj->context, all.next);
    stp_free(obj->context, all.needed);
    return result;
}
