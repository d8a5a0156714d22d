// SPDX-License-Identifier: MIT
// Moves the staged content into the scene that is built, below a separate object that converts the
// axes.
#include "embed/builder.h"
#include "import/reading/import.h"

#include <assert.h>
#include <string.h>

/// Offsets of the staged scene's items in the target scene; `root`: the object above them.
typedef struct offsets {
    uint32_t material, texture, mesh, point_set, object, root;
} offsets;

static void shift_texture(stp_texture_use* use, const offsets* to)
{
    use->texture = use->texture != STP_NONE ? use->texture + to->texture : STP_NONE;
}

// The target scene owns arrays as soon as they are passed, even on failure.
static stp_result move_parts(stp_scene* staged, stp_scene* scene, const offsets* to)
{
    stp_result result = STP_OK;
    for (size_t i = 0; i < staged->texture_count && result == STP_OK; ++i) {
        stp_texture texture = staged->textures[i];
        staged->textures[i] = (stp_texture){0};
        result = stp_scene_add_texture(scene, &texture, NULL);
    }
    for (size_t i = STP_BUILDER_MATERIAL; i < staged->material_count && result == STP_OK; ++i) {
        stp_material material = staged->materials[i];
        shift_texture(&material.base_color_texture, to);
        result = stp_scene_add_material(scene, &material, NULL);
    }
    for (size_t i = 0; i < staged->mesh_count && result == STP_OK; ++i) {
        stp_mesh mesh = staged->meshes[i];
        staged->meshes[i] = (stp_mesh){.name = mesh.name};
        mesh.material += to->material;
        result = stp_scene_add_mesh(scene, &mesh, NULL);
    }
    for (size_t i = 0; i < staged->point_set_count && result == STP_OK; ++i) {
        stp_point_set points = staged->point_sets[i];
        staged->point_sets[i] = (stp_point_set){.name = points.name};
        points.material += to->material;
        result = stp_scene_add_point_set(scene, &points, NULL);
    }
    assert((result != STP_OK || (scene->texture_count == to->texture + staged->texture_count &&
                                 scene->mesh_count == to->mesh + staged->mesh_count)) &&
           "offsets hold for all items");
    return result;
}

static stp_part shifted(stp_part part, const offsets* to)
{
    assert(part.index != STP_NONE && "the staged scene is not partitioned");
    part.index += part.kind == STP_PART_MESH ? to->mesh : to->point_set;
    return part;
}

static stp_result add_objects(const stp_scene* staged, stp_scene* scene, const offsets* to)
{
    stp_result result = STP_OK;
    for (size_t i = 0; i < staged->object_count && result == STP_OK; ++i) {
        stp_object object = staged->objects[i];
        assert(object.parent == STP_NONE || object.parent < i);
        object.parent = object.parent == STP_NONE ? to->root : object.parent + to->object;
        result = stp_scene_add_object(scene, &object, NULL);
        for (uint32_t k = 0; k < object.part_count && result == STP_OK; ++k) {
            stp_part part = staged->parts[object.first_part + k];
            result = stp_scene_add_part(scene, shifted(part, to));
        }
        for (uint32_t k = 0; k < object.instance_count && result == STP_OK; ++k) {
            result = stp_scene_add_instance(scene, &staged->instances[object.first_instance + k]);
        }
    }
    assert(result != STP_OK || scene->object_count == to->object + staged->object_count);
    return result;
}

static const char* name_of(const stp_scene* staged, stp_part part)
{
    return part.kind == STP_PART_MESH ? staged->meshes[part.index].name
                                      : staged->point_sets[part.index].name;
}

/// Parts without an object are shown untransformed, each as a separate object.
static stp_result add_loose_parts(const stp_builder* builder, stp_scene* scene, const offsets* to)
{
    const stp_scene* staged = builder->staged;
    stp_result result = STP_OK;
    uint8_t* used[2] = {STP_NEW_ZEROED(builder->context, uint8_t, staged->mesh_count + 1),
                        STP_NEW_ZEROED(builder->context, uint8_t, staged->point_set_count + 1)};
    if (used[0] == NULL || used[1] == NULL) {
        result = stp_fail_memory(builder->context);
    }
    for (size_t i = 0; i < staged->part_count && result == STP_OK; ++i) {
        used[staged->parts[i].kind == STP_PART_POINTS][staged->parts[i].index] = 1;
    }
    for (size_t i = 0; i < builder->part_count && result == STP_OK; ++i) {
        stp_part part = builder->parts[i];
        if (used[part.kind == STP_PART_POINTS][part.index] == 0) {
            stp_object object = {.name = name_of(staged, part),
                                 .parent = to->root,
                                 .transform = stp_affine_identity()};
            result = stp_scene_add_object(scene, &object, NULL);
            result = result == STP_OK ? stp_scene_add_part(scene, shifted(part, to)) : result;
        }
    }
    stp_free(builder->context, used[0]);
    stp_free(builder->context, used[1]);
    return result;
}

static uint64_t bytes_of(const stp_scene* staged)
{
    uint64_t bytes = 0;
    for (size_t i = 0; i < staged->mesh_count; ++i) {
        bytes += 12 * ((uint64_t)staged->meshes[i].vertex_count + staged->meshes[i].triangle_count);
    }
    for (size_t i = 0; i < staged->point_set_count; ++i) {
        bytes += 12 * (uint64_t)staged->point_sets[i].point_count;
    }
    return bytes;
}

/// Adds the source and the root object of the staged content.
static stp_result add_root(const stp_builder* builder, stp_scene* scene, uint32_t* root)
{
    stp_source source = {
        .path = builder->name, .format = "memory", .bytes = bytes_of(builder->staged)};
    stp_object object = {
        .name = builder->name, .parent = STP_NONE, .transform = stp_affine_identity()};
    stp_import import = {.context = builder->context,
                         .scene = scene,
                         .path = builder->name,
                         .desc = {.unit_metres = builder->desc.unit_metres}};
    stp_result result = stp_scene_add_source(scene, &source);
    result = result == STP_OK ? stp_scene_add_object(scene, &object, &import.root) : result;
    if (result == STP_OK) {
        stp_import_set_axes(&import, builder->desc.up != 0 ? builder->desc.up : 'y', 0.0);
        *root = import.root;
    }
    return result;
}

stp_result stp_builder_move(stp_scene* scene, const char* input, void* user)
{
    (void)input;
    stp_builder* builder = user;
    if (builder->moved) {
        return stp_fail(builder->context, STP_ERROR_IO,
                        "%s: results of the build were changed by another program", builder->name);
    }
    builder->moved = true;
    offsets to = {.material = (uint32_t)scene->material_count - STP_BUILDER_MATERIAL,
                  .texture = (uint32_t)scene->texture_count,
                  .mesh = (uint32_t)scene->mesh_count,
                  .point_set = (uint32_t)scene->point_set_count};
    stp_result result = add_root(builder, scene, &to.root);
    to.object = to.root + 1;
    assert(result != STP_OK || to.object == scene->object_count);
    result = result == STP_OK ? move_parts(builder->staged, scene, &to) : result;
    result = result == STP_OK ? add_objects(builder->staged, scene, &to) : result;
    result = result == STP_OK ? add_loose_parts(builder, scene, &to) : result;
    if (result == STP_OK && scene->damaged.count == 0) {
        scene->damaged = builder->staged->damaged; // logged by stp_scene_finish
    }
    return result;
}
