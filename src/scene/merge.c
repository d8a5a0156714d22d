// SPDX-License-Identifier: MIT
//
// Inputs repeat content: each glTF file its default material, each copy of an assembly its meshes
// and pictures. Identity is by content (128-bit hashes), bottom-up from items without references.
#include "scene/bulk.h"
#include "scene/finish_steps.h"

#include <assert.h>

typedef enum merge_kind { TEXTURES, MATERIALS, MESHES, POINT_SETS } merge_kind;

typedef struct merging {
    stp_scene* scene;
    merge_kind kind;
    size_t count;
    stp_hash* hashes; ///< content of each item
    uint32_t* kept;   ///< per old index: first item with its content, then that one's new index
} merging;

static bool is_known(stp_hash content)
{
    return content.low != 0 || content.high != 0; // set when it was spilled
}

static stp_hash with_material(const stp_scene* scene, stp_hash content, uint32_t material)
{
    stp_hash other = scene->materials[material].content;
    return stp_hash_bytes(content, &other, sizeof(other));
}

static void hash_items(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const merging* m = user;
    const stp_scene* scene = m->scene;
    for (size_t i = begin; i < end; ++i) {
        if (m->kind == TEXTURES) {
            stp_texture* texture = &scene->textures[i];
            texture->content =
                is_known(texture->content) ? texture->content : stp_texture_hash(texture);
            m->hashes[i] = texture->content;
        } else if (m->kind == MATERIALS) {
            stp_material* material = &scene->materials[i];
            material->content = stp_material_hash(scene, material);
            m->hashes[i] = material->content;
        } else if (m->kind == MESHES) {
            stp_mesh* mesh = &scene->meshes[i];
            mesh->content = is_known(mesh->content) ? mesh->content : stp_mesh_hash(mesh);
            m->hashes[i] = with_material(scene, mesh->content, mesh->material);
        } else {
            stp_point_set* points = &scene->point_sets[i];
            points->content = is_known(points->content) ? points->content : stp_points_hash(points);
            m->hashes[i] = with_material(scene, points->content, points->material);
        }
    }
}

// Whether item i stays; it then becomes number *left - 1. Call in ascending order.
static bool is_kept(merging* m, size_t i, size_t* left)
{
    assert(m->kept[i] <= i && *left <= i && "the first item of a content is kept");
    if (m->kept[i] != i) {
        m->kept[i] = m->kept[m->kept[i]];
        return false;
    }
    m->kept[i] = (uint32_t)*left;
    *left += 1;
    return true;
}

static void remap_texture(const merging* m, stp_texture_use* use)
{
    assert(use->texture == STP_NONE || use->texture < m->count);
    use->texture = use->texture != STP_NONE ? m->kept[use->texture] : STP_NONE;
}

static void drop_textures(merging* m)
{
    stp_scene* scene = m->scene;
    size_t left = 0;
    for (size_t i = 0; i < m->count; ++i) {
        if (is_kept(m, i, &left)) {
            scene->textures[left - 1] = scene->textures[i];
        } else {
            stp_texture_free_arrays(scene, &scene->textures[i]);
        }
    }
    scene->texture_count = left;
    for (size_t i = 0; i < scene->material_count; ++i) {
        remap_texture(m, &scene->materials[i].base_color_texture);
        remap_texture(m, &scene->materials[i].metallic_roughness_texture);
        remap_texture(m, &scene->materials[i].emissive_texture);
        remap_texture(m, &scene->materials[i].normal_texture);
    }
}

static void drop_materials(merging* m)
{
    stp_scene* scene = m->scene;
    size_t left = 0;
    for (size_t i = 0; i < m->count; ++i) {
        if (is_kept(m, i, &left)) {
            scene->materials[left - 1] = scene->materials[i];
        }
    }
    scene->material_count = left;
    for (size_t i = 0; i < scene->mesh_count; ++i) {
        scene->meshes[i].material = m->kept[scene->meshes[i].material];
    }
    for (size_t i = 0; i < scene->point_set_count; ++i) {
        scene->point_sets[i].material = m->kept[scene->point_sets[i].material];
    }
}

static void remap_parts(const merging* m, stp_part_kind kind)
{
    for (size_t i = 0; i < m->scene->part_count; ++i) {
        stp_part* part = &m->scene->parts[i];
        part->index = part->kind == kind ? m->kept[part->index] : part->index;
    }
}

static void drop_meshes(merging* m)
{
    stp_scene* scene = m->scene;
    size_t left = 0;
    for (size_t i = 0; i < m->count; ++i) {
        if (is_kept(m, i, &left)) {
            scene->meshes[left - 1] = scene->meshes[i];
        } else {
            stp_mesh_free_arrays(scene, &scene->meshes[i]);
        }
    }
    scene->mesh_count = left;
    remap_parts(m, STP_PART_MESH);
}

static void drop_point_sets(merging* m)
{
    stp_scene* scene = m->scene;
    size_t left = 0;
    for (size_t i = 0; i < m->count; ++i) {
        if (is_kept(m, i, &left)) {
            scene->point_sets[left - 1] = scene->point_sets[i];
        } else {
            stp_points_free_arrays(scene, &scene->point_sets[i]);
        }
    }
    scene->point_set_count = left;
    remap_parts(m, STP_PART_POINTS);
}

static stp_result merge_items(stp_scene* scene, merge_kind kind, size_t count,
                              void (*drop)(merging* m))
{
    stp_context* context = scene->context;
    merging m = {.scene = scene, .kind = kind, .count = count};
    stp_content_table table = {0};
    m.hashes = STP_NEW_ARRAY(context, stp_hash, count);
    m.kept = STP_NEW_ARRAY(context, uint32_t, count);
    stp_result result = m.hashes != NULL && m.kept != NULL ? STP_OK : stp_fail_memory(context);
    if (result == STP_OK) {
        stp_parallel_for(context, count, 4, hash_items, &m);
    }
    for (size_t i = 0; result == STP_OK && i < count; ++i) {
        result = stp_content_table_find(context, &table, m.hashes[i], (uint32_t)i, &m.kept[i]);
    }
    if (result == STP_OK) {
        drop(&m);
    }
    stp_content_table_destroy(context, &table);
    stp_free(context, m.kept);
    stp_free(context, m.hashes);
    return result;
}

stp_result stp_scene_merge(stp_scene* scene)
{
    stp_content_table_destroy(scene->context, &scene->spilled); // indices change
    stp_result result = merge_items(scene, TEXTURES, scene->texture_count, drop_textures);
    if (result == STP_OK) {
        result = merge_items(scene, MATERIALS, scene->material_count, drop_materials);
    }
    if (result == STP_OK) {
        result = merge_items(scene, MESHES, scene->mesh_count, drop_meshes);
    }
    if (result == STP_OK) {
        result = merge_items(scene, POINT_SETS, scene->point_set_count, drop_point_sets);
    }
    return result;
}
