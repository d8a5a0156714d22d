// SPDX-License-Identifier: MIT
// Adds the mesh of a PLY file to the scene: as it is, or a mesh for each picture if faces have
// colours or texture coordinates of their own.
#include "import/ply/ply.h"
#include "import/reading/smooth.h"
#include "import/reading/surface.h"

#include <assert.h>
#include <string.h>

// The material with picture `texture`; STP_NONE: without.
static stp_result add_material(const stp_ply* ply, stp_pictures* pictures, uint32_t texture,
                               uint32_t* index)
{
    stp_material material = stp_material_plain();
    stp_result result = STP_OK;
    assert(texture == STP_NONE || texture < ply->texture_count);
    if (texture != STP_NONE) {
        result = stp_pictures_read(pictures, "TextureFile", ply->textures[texture], STP_WRAP_REPEAT,
                                   &material.base_color_texture.texture);
    }
    return result == STP_OK ? stp_scene_add_material(ply->import->scene, &material, index) : result;
}

static uint16_t linear_color(float value, size_t channel)
{
    return stp_unorm16(channel < 3 ? stp_srgb_to_linear(value) : value);
}

static stp_result add_part(const stp_ply* ply, stp_mesh* mesh)
{
    stp_part part = {.kind = STP_PART_MESH};
    stp_result result = stp_import_add_mesh(ply->import, mesh, &part.index);
    return result == STP_OK ? stp_scene_add_part(ply->import->scene, part) : result;
}

// The picture of texture coordinates of vertices.
static uint32_t first_texture(const stp_ply_vertices* v)
{
    return v->ply->texture_count > 0 && v->texcoords != NULL ? 0 : STP_NONE;
}

static stp_result add_whole(stp_ply_vertices* v, stp_ply_faces* f, stp_pictures* pictures)
{
    stp_context* context = v->ply->context;
    stp_mesh mesh = {.vertex_count = (uint32_t)v->count,
                     .triangle_count = (uint32_t)(f->count / 3)};
    assert(f->count % 3 == 0 && f->count / 3 < STP_NONE && v->count < STP_NONE);
    stp_result result = add_material(v->ply, pictures, first_texture(v), &mesh.material);
    if (result != STP_OK) {
        return result;
    }
    if (v->colors != NULL) {
        mesh.colors = STP_NEW_ARRAY(context, uint16_t, 4 * v->count);
        if (mesh.colors == NULL) {
            return stp_fail_memory(context);
        }
        stp_ply_color_scale scale = stp_ply_find_color_scale(&v->color_range);
        for (size_t i = 0; i < 4 * v->count; ++i) {
            mesh.colors[i] = linear_color(stp_ply_scaled_color(&scale, i % 4, v->colors[i]), i % 4);
        }
    }
    mesh.positions = v->positions;
    mesh.normals = v->normals;
    mesh.texcoords[0] = v->texcoords;
    mesh.indices = f->indices;
    v->positions = v->normals = v->texcoords = NULL;
    f->indices = NULL;
    return add_part(v->ply, &mesh);
}

// Allocates the arrays of a group's mesh. @return false if memory runs out
static bool alloc_mesh(const stp_ply_vertices* v, const stp_ply_wedges* w, size_t count,
                       stp_mesh* mesh)
{
    stp_context* context = v->ply->context;
    bool textured = w->any_texcoords || v->texcoords != NULL;
    bool colored = w->any_colors || v->colors != NULL;
    mesh->positions = STP_NEW_ARRAY(context, float, 3 * count);
    mesh->normals = v->normals != NULL ? STP_NEW_ARRAY(context, float, 3 * count) : NULL;
    mesh->texcoords[0] = textured ? STP_NEW_ARRAY(context, float, 2 * count) : NULL;
    mesh->colors = colored ? STP_NEW_ARRAY(context, uint16_t, 4 * count) : NULL;
    return mesh->positions != NULL && (mesh->normals != NULL) == (v->normals != NULL) &&
           (mesh->texcoords[0] != NULL) == textured && (mesh->colors != NULL) == colored;
}

static void fill_vertex(const stp_ply_vertices* v, const stp_ply_wedges* w,
                        const stp_ply_wedge* wedge, const stp_ply_color_scale* scale, size_t index,
                        stp_mesh* mesh)
{
    size_t from = wedge->vertex;
    assert(from < v->count);
    memcpy(mesh->positions + 3 * index, v->positions + 3 * from, 3 * sizeof(float));
    if (mesh->normals != NULL) {
        memcpy(mesh->normals + 3 * index, v->normals + 3 * from, 3 * sizeof(float));
    }
    if (mesh->texcoords[0] != NULL) {
        const float* texcoord = w->any_texcoords ? wedge->texcoord : v->texcoords + 2 * from;
        memcpy(mesh->texcoords[0] + 2 * index, texcoord, 2 * sizeof(float));
    }
    for (size_t i = 0; i < 4 && mesh->colors != NULL; ++i) {
        float value = w->any_colors ? wedge->color[i]
                                    : stp_ply_scaled_color(scale, i, v->colors[4 * from + i]);
        mesh->colors[4 * index + i] = linear_color(value, i);
    }
}

static stp_result add_group(const stp_ply_vertices* v, const stp_ply_wedges* w,
                            stp_ply_group* group, stp_pictures* pictures, uint32_t texture)
{
    stp_mesh mesh = {.vertex_count = (uint32_t)group->count,
                     .triangle_count = (uint32_t)(group->index_count / 3)};
    stp_result result = add_material(v->ply, pictures, texture, &mesh.material);
    if (result != STP_OK) {
        return result;
    }
    if (!alloc_mesh(v, w, group->count, &mesh)) {
        void* made[] = {mesh.positions, mesh.normals, mesh.texcoords[0], mesh.colors};
        for (size_t i = 0; i < sizeof(made) / sizeof(made[0]); ++i) {
            stp_free(v->ply->context, made[i]);
        }
        return stp_fail_memory(v->ply->context);
    }
    stp_ply_color_scale scale = stp_ply_find_color_scale(&v->color_range);
    for (size_t i = 0; i < group->count; ++i) {
        fill_vertex(v, w, &group->wedges[i], &scale, i, &mesh);
    }
    mesh.indices = group->indices;
    group->indices = NULL;
    return add_part(v->ply, &mesh);
}

stp_result stp_ply_add_mesh(stp_ply_vertices* v, stp_ply_faces* f)
{
    stp_ply_wedges* w = &f->wedges;
    stp_pictures pictures = stp_pictures_create(v->ply->import);
    stp_result result = STP_OK;
    for (size_t i = 0; i < w->group_count && result == STP_OK; ++i) {
        uint32_t own = i < v->ply->texture_count ? (uint32_t)i : STP_NONE;
        if (w->groups[i].index_count > 0) {
            result = add_group(v, w, &w->groups[i], &pictures,
                               w->any_texcoords ? own : first_texture(v));
        }
    }
    bool whole = f->count > 0 || !w->active;
    result = result == STP_OK && whole ? add_whole(v, f, &pictures) : result;
    stp_pictures_destroy(&pictures);
    return result;
}
