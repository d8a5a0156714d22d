// SPDX-License-Identifier: MIT
#include "base/core/printable.h"
#include "scene/bulk.h"
#include "scene/finish_steps.h"

#include <assert.h>
#include <string.h>

#define TEXT_BLOCK_SIZE ((size_t)64 << 10)

stp_texture_use stp_texture_use_none(void)
{
    return (stp_texture_use){.texture = STP_NONE, .transform = {{1, 0, 0}, {0, 1, 0}}};
}

const stp_texture* stp_scene_used_texture(const stp_scene* scene, const stp_texture_use* use)
{
    if (use->texture >= scene->texture_count) {
        return NULL;
    }
    const stp_texture* texture = &scene->textures[use->texture];
    return texture->texels != NULL && texture->width != 0 && texture->height != 0 ? texture : NULL;
}

stp_material stp_material_default(void)
{
    return (stp_material){
        .base_color = {1, 1, 1, 1},
        .metallic = 1.0f,
        .roughness = 1.0f,
        .alpha_cutoff = 0.5f,
        .base_color_texture = stp_texture_use_none(),
        .metallic_roughness_texture = stp_texture_use_none(),
        .emissive_texture = stp_texture_use_none(),
        .normal_texture = stp_texture_use_none(),
        .normal_scale = 1.0f,
    };
}

stp_result stp_scene_create(stp_context* context, stp_scene** scene)
{
    stp_scene* made = STP_NEW_ZEROED(context, stp_scene, 1);
    if (made == NULL) {
        return stp_fail_memory(context);
    }
    made->context = context;
    made->text = stp_arena_create(context, TEXT_BLOCK_SIZE);
    made->root = STP_NONE;
    made->up = "y";
    stp_material material = stp_material_default();
    stp_result result = stp_scene_add_material(made, &material, NULL);
    if (result != STP_OK) {
        stp_scene_destroy(made);
        return result;
    }
    *scene = made;
    return STP_OK;
}

void stp_scene_destroy(stp_scene* scene)
{
    if (scene == NULL) {
        return;
    }
    stp_context* context = scene->context;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        stp_mesh_free_arrays(scene, &scene->meshes[i]);
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        stp_points_free_arrays(scene, &scene->point_sets[i]);
    }
    for (size_t i = 0; i < scene->texture_count; ++i) {
        stp_texture_free_arrays(scene, &scene->textures[i]);
    }
    stp_content_table_destroy(context, &scene->spilled);
    void* arrays[] = {scene->meshes,  scene->point_sets, scene->materials, scene->textures,
                      scene->objects, scene->parts,      scene->instances, scene->views,
                      scene->sources, scene->nodes,      scene->edges,     scene->node_parts,
                      scene->looks,   scene->look_bins};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(context, arrays[i]);
    }
    stp_arena_destroy(&scene->text);
    stp_free(context, scene);
}

// Replaces *text by a copy owned by the scene, truncated to the maximum length.
static stp_result keep_text(stp_scene* scene, const char** text)
{
    if (*text != NULL) {
        size_t length = strlen(*text);
        if (length > STP_SCENE_TEXT_LIMIT) {
            length = stp_utf8_whole(*text, STP_SCENE_TEXT_LIMIT);
            scene->shortened += scene->shortened < UINT32_MAX ? 1 : 0;
        }
        *text = stp_arena_copy_text(&scene->text, *text, length);
        if (*text == NULL) {
            return stp_fail_memory(scene->context);
        }
    }
    return STP_OK;
}

stp_result stp_scene_make_room(stp_context* context, void* array_address, size_t* capacity,
                               size_t count, size_t size)
{
    if (count > STP_NONE) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "the scene has more than 2^32 - 1 elements of a kind");
    }
    return stp_make_room(context, array_address, capacity, count, size) ? STP_OK
                                                                        : stp_fail_memory(context);
}

static void assign_indices(uint32_t* index, size_t count)
{
    if (index != NULL) {
        *index = (uint32_t)count;
    }
}

static void note_damage(stp_scene* scene, stp_part part, uint32_t dropped)
{
    stp_damage* d = &scene->damaged;
    if (dropped > 0 && d->count++ == 0) {
        d->first = part;
        d->dropped = dropped;
    }
}

stp_result stp_scene_add_mesh(stp_scene* scene, const stp_mesh* mesh, uint32_t* index)
{
    stp_mesh added = *mesh;
    added.spilled = false;
    added.content = (stp_hash){0};
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->meshes, scene->mesh_capacity,
                                            scene->mesh_count + 1);
    if (result != STP_OK) {
        scene->bulk_bytes += stp_mesh_bytes(&added);
        stp_mesh_free_arrays(scene, &added);
        return result;
    }
    assign_indices(index, scene->mesh_count);
    stp_mesh* kept = &scene->meshes[scene->mesh_count++];
    *kept = added;
    note_damage(scene, (stp_part){STP_PART_MESH, (uint32_t)(scene->mesh_count - 1)},
                stp_mesh_drop_distant(kept));
    kept->bounds = stp_box_empty();
    for (uint32_t i = 0; i < kept->vertex_count; ++i) {
        const float* p = kept->positions + 3 * (size_t)i;
        stp_box_add(&kept->bounds, (stp_vec3){p[0], p[1], p[2]});
    }
    result = stp_mesh_account(scene, (uint32_t)(scene->mesh_count - 1));
    return result == STP_OK ? keep_text(scene, &kept->name) : result;
}

static stp_result add_points(stp_scene* scene, const stp_point_set* points, bool spilled,
                             uint32_t* index)
{
    stp_point_set added = *points;
    added.spilled = spilled;
    added.content = (stp_hash){0};
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->point_sets,
                                            scene->point_set_capacity, scene->point_set_count + 1);
    if (result != STP_OK) {
        scene->bulk_bytes += spilled ? 0 : stp_points_bytes(&added);
        stp_points_free_arrays(scene, &added);
        return result;
    }
    assign_indices(index, scene->point_set_count);
    stp_point_set* kept = &scene->point_sets[scene->point_set_count++];
    *kept = added;
    note_damage(scene, (stp_part){STP_PART_POINTS, (uint32_t)(scene->point_set_count - 1)},
                stp_point_set_measure(kept));
    result = stp_points_account(scene, (uint32_t)(scene->point_set_count - 1));
    return result == STP_OK ? keep_text(scene, &kept->name) : result;
}

stp_result stp_scene_add_point_set(stp_scene* scene, const stp_point_set* points, uint32_t* index)
{
    return add_points(scene, points, false, index);
}

stp_result stp_scene_add_spilled_points(stp_scene* scene, const stp_point_set* points,
                                        uint32_t* index)
{
    return add_points(scene, points, true, index);
}

stp_result stp_scene_add_material(stp_scene* scene, const stp_material* material, uint32_t* index)
{
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->materials,
                                            scene->material_capacity, scene->material_count + 1);
    if (result != STP_OK) {
        return result;
    }
    assign_indices(index, scene->material_count);
    stp_material* kept = &scene->materials[scene->material_count++];
    *kept = *material;
    if (material->unlit || material->normal_scale == 0.0f) { // a normal map would change nothing
        kept->normal_texture = stp_texture_use_none();
    }
    return keep_text(scene, &kept->name);
}

stp_result stp_scene_add_texture(stp_scene* scene, const stp_texture* texture, uint32_t* index)
{
    stp_texture added = *texture;
    added.spilled = false;
    added.content = (stp_hash){0};
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->textures,
                                            scene->texture_capacity, scene->texture_count + 1);
    if (result != STP_OK) {
        scene->bulk_bytes += stp_texture_bytes(&added);
        stp_texture_free_arrays(scene, &added);
        return result;
    }
    assign_indices(index, scene->texture_count);
    stp_texture* kept = &scene->textures[scene->texture_count++];
    *kept = added;
    result = stp_texture_account(scene, (uint32_t)(scene->texture_count - 1));
    return result == STP_OK ? keep_text(scene, &kept->name) : result;
}

stp_result stp_scene_add_object(stp_scene* scene, const stp_object* object, uint32_t* index)
{
    assert(object->parent == STP_NONE || object->parent < scene->object_count);
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->objects, scene->object_capacity,
                                            scene->object_count + 1);
    if (result != STP_OK) {
        return result;
    }
    assign_indices(index, scene->object_count);
    stp_object* kept = &scene->objects[scene->object_count++];
    *kept = (stp_object){
        .name = object->name,
        .id = object->id,
        .parent = object->parent,
        .transform = object->transform,
        .first_part = (uint32_t)scene->part_count,
        .first_instance = (uint32_t)scene->instance_count,
        .use = STP_NONE,
        .flags = object->flags,
        .node = STP_NONE,
    };
    result = keep_text(scene, &kept->name);
    return result == STP_OK ? keep_text(scene, &kept->id) : result;
}

stp_result stp_scene_add_part(stp_scene* scene, stp_part part)
{
    assert(scene->object_count > 0);
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->parts, scene->part_capacity,
                                            scene->part_count + 1);
    if (result != STP_OK) {
        return result;
    }
    scene->parts[scene->part_count++] = part;
    scene->objects[scene->object_count - 1].part_count += 1;
    return STP_OK;
}

stp_result stp_scene_add_instance(stp_scene* scene, const stp_affine* transform)
{
    assert(scene->object_count > 0);
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->instances,
                                            scene->instance_capacity, scene->instance_count + 1);
    if (result != STP_OK) {
        return result;
    }
    scene->instances[scene->instance_count++] = *transform;
    scene->objects[scene->object_count - 1].instance_count += 1;
    return STP_OK;
}

stp_result stp_scene_add_use(stp_scene* scene, uint32_t object)
{
    assert(scene->object_count > 0 && object < scene->object_count - 1);
    scene->objects[scene->object_count - 1].use = object;
    return STP_OK;
}

stp_result stp_scene_add_view(stp_scene* scene, const stp_scene_view* view)
{
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->views, scene->view_capacity,
                                            scene->view_count + 1);
    if (result != STP_OK) {
        return result;
    }
    stp_scene_view* kept = &scene->views[scene->view_count++];
    *kept = *view;
    return keep_text(scene, &kept->name);
}

stp_result stp_scene_add_source(stp_scene* scene, const stp_source* source)
{
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->sources, scene->source_capacity,
                                            scene->source_count + 1);
    if (result != STP_OK) {
        return result;
    }
    stp_source* kept = &scene->sources[scene->source_count++];
    *kept = *source;
    result = keep_text(scene, &kept->path);
    result = result == STP_OK ? keep_text(scene, &kept->format) : result;
    return result == STP_OK ? keep_text(scene, &kept->coordinate_system) : result;
}

stp_result stp_scene_set_coordinate_system(stp_scene* scene, size_t source, const char* text)
{
    assert(source < scene->source_count);
    scene->sources[source].coordinate_system = text;
    return keep_text(scene, &scene->sources[source].coordinate_system);
}
