// SPDX-License-Identifier: MIT
#include "scene/bulk.h"

#include "scene/finish_steps.h"

#include <assert.h>
#include <string.h>

#define LINE ((size_t)64)

static stp_bulk_array array_of(void* bytes, size_t count, size_t size)
{
    return (stp_bulk_array){.bytes = bytes, .size = bytes != NULL ? count * size : 0};
}

void stp_mesh_get_arrays(const stp_mesh* mesh, stp_bulk_array arrays[STP_MESH_ARRAYS])
{
    size_t vertices = mesh->vertex_count;
    arrays[0] = array_of(mesh->positions, vertices, 3 * sizeof(float));
    arrays[1] = array_of(mesh->normals, vertices, 3 * sizeof(float));
    arrays[2] = array_of(mesh->texcoords[0], vertices, 2 * sizeof(float));
    arrays[3] = array_of(mesh->texcoords[1], vertices, 2 * sizeof(float));
    arrays[4] = array_of(mesh->colors, vertices, 4 * sizeof(uint16_t));
    arrays[5] = array_of(mesh->indices, mesh->triangle_count, 3 * sizeof(uint32_t));
}

void stp_mesh_set_arrays(stp_mesh* mesh, const stp_bulk_array arrays[STP_MESH_ARRAYS])
{
    mesh->positions = arrays[0].bytes;
    mesh->normals = arrays[1].bytes;
    mesh->texcoords[0] = arrays[2].bytes;
    mesh->texcoords[1] = arrays[3].bytes;
    mesh->colors = arrays[4].bytes;
    mesh->indices = arrays[5].bytes;
}

void stp_points_get_arrays(const stp_point_set* points, stp_bulk_array arrays[STP_POINT_ARRAYS])
{
    arrays[0] = array_of(points->positions, points->point_count, 3 * sizeof(float));
    arrays[1] = array_of(points->normals, points->point_count, 3 * sizeof(float));
    arrays[2] = array_of(points->colors, points->point_count, 4);
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        arrays[STP_POINT_ATTRIBUTE_ARRAY + i] = array_of(points->attributes[i], points->point_count,
                                                         stp_attribute_size((stp_attribute)i));
    }
}

void stp_points_set_arrays(stp_point_set* points, const stp_bulk_array arrays[STP_POINT_ARRAYS])
{
    points->positions = arrays[0].bytes;
    points->normals = arrays[1].bytes;
    points->colors = arrays[2].bytes;
    for (int i = 0; i < STP_ATTRIBUTES; ++i) {
        points->attributes[i] = arrays[STP_POINT_ATTRIBUTE_ARRAY + i].bytes;
    }
}

void stp_texture_get_arrays(const stp_texture* texture, stp_bulk_array arrays[STP_TEXTURE_ARRAYS])
{
    arrays[0] = array_of(texture->texels, (size_t)texture->width * texture->height, 4);
    arrays[1] = array_of(texture->encoded, texture->encoded_size, 1);
}

static void set_texture_arrays(stp_texture* texture,
                               const stp_bulk_array arrays[STP_TEXTURE_ARRAYS])
{
    texture->texels = arrays[0].bytes;
    texture->encoded = arrays[1].bytes;
    texture->encoded_size = arrays[1].size;
}

static uint64_t sum_sizes(const stp_bulk_array* arrays, size_t count)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < count; ++i) {
        sum += arrays[i].size;
    }
    return sum;
}

uint64_t stp_mesh_bytes(const stp_mesh* mesh)
{
    stp_bulk_array arrays[STP_MESH_ARRAYS];
    stp_mesh_get_arrays(mesh, arrays);
    return sum_sizes(arrays, STP_MESH_ARRAYS);
}

uint64_t stp_points_bytes(const stp_point_set* points)
{
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    stp_points_get_arrays(points, arrays);
    return sum_sizes(arrays, STP_POINT_ARRAYS);
}

uint64_t stp_texture_bytes(const stp_texture* texture)
{
    stp_bulk_array arrays[STP_TEXTURE_ARRAYS];
    stp_texture_get_arrays(texture, arrays);
    return sum_sizes(arrays, STP_TEXTURE_ARRAYS);
}

// Frees the arrays unless they are in the spill, and subtracts their size from the count.
static void free_arrays(stp_scene* scene, stp_bulk_array* arrays, size_t count, bool spilled)
{
    for (size_t i = 0; i < count; ++i) {
        if (!spilled) {
            assert(scene->bulk_bytes >= arrays[i].size && "freed arrays were counted");
            scene->bulk_bytes -= arrays[i].size;
            stp_free(scene->context, arrays[i].bytes);
        }
        arrays[i] = (stp_bulk_array){0};
    }
}

void stp_mesh_free_arrays(stp_scene* scene, stp_mesh* mesh)
{
    stp_bulk_array arrays[STP_MESH_ARRAYS];
    stp_mesh_get_arrays(mesh, arrays);
    free_arrays(scene, arrays, STP_MESH_ARRAYS, mesh->spilled);
    stp_mesh_set_arrays(mesh, arrays);
}

void stp_points_free_arrays(stp_scene* scene, stp_point_set* points)
{
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    stp_points_get_arrays(points, arrays);
    free_arrays(scene, arrays, STP_POINT_ARRAYS, points->spilled);
    stp_points_set_arrays(points, arrays);
}

void stp_texture_free_arrays(stp_scene* scene, stp_texture* texture)
{
    stp_bulk_array arrays[STP_TEXTURE_ARRAYS];
    stp_texture_get_arrays(texture, arrays);
    free_arrays(scene, arrays, STP_TEXTURE_ARRAYS, texture->spilled);
    set_texture_arrays(texture, arrays);
}

void stp_scene_use_spill(stp_scene* scene, stp_spill* spill, uint64_t above_bytes)
{
    scene->spill = spill;
    scene->spill_above = above_bytes;
}

stp_result stp_bulk_alloc_spilled(stp_spill* spill, stp_bulk_array* arrays, size_t count)
{
    size_t size = 0;
    for (size_t i = 0; i < count; ++i) {
        size += (arrays[i].size + LINE - 1) / LINE * LINE;
    }
    unsigned char* place = stp_spill_alloc(spill, size);
    if (place == NULL) {
        return STP_ERROR_IO; // already logged
    }
    for (size_t i = 0; i < count; ++i) {
        arrays[i].bytes = arrays[i].size != 0 ? place : NULL;
        place += (arrays[i].size + LINE - 1) / LINE * LINE;
    }
    return STP_OK;
}

// Moves arrays from memory to the spill.
static stp_result spill_arrays(stp_scene* scene, stp_bulk_array* arrays, size_t count)
{
    stp_bulk_array moved[STP_POINT_ARRAYS]; // the most that any item has
    assert(count <= STP_POINT_ARRAYS && scene->spill != NULL);
    memcpy(moved, arrays, count * sizeof(*arrays));
    stp_result result = stp_bulk_alloc_spilled(scene->spill, moved, count);
    if (result != STP_OK) {
        return result;
    }
    for (size_t i = 0; i < count; ++i) {
        if (arrays[i].size != 0) {
            memcpy(moved[i].bytes, arrays[i].bytes, arrays[i].size);
        }
    }
    free_arrays(scene, arrays, count, false);
    memcpy(arrays, moved, count * sizeof(*arrays));
    return STP_OK;
}

// Counts the new bytes. @return whether they must go to the spill
static bool count_added(stp_scene* scene, uint64_t bytes)
{
    scene->bulk_bytes += bytes;
    return scene->spill != NULL && bytes != 0 && scene->bulk_bytes > scene->spill_above;
}

stp_result stp_mesh_account(stp_scene* scene, uint32_t index)
{
    assert(index < scene->mesh_count && !scene->meshes[index].spilled);
    stp_mesh* mesh = &scene->meshes[index];
    if (!count_added(scene, stp_mesh_bytes(mesh))) {
        return STP_OK;
    }
    uint32_t found = index;
    stp_bulk_array arrays[STP_MESH_ARRAYS];
    mesh->content = stp_mesh_hash(mesh);
    stp_result result =
        stp_content_table_find(scene->context, &scene->spilled, mesh->content, index, &found);
    if (result == STP_OK && found != index) {
        stp_mesh_free_arrays(scene, mesh);
        stp_mesh_get_arrays(&scene->meshes[found], arrays);
    } else if (result == STP_OK) {
        stp_mesh_get_arrays(mesh, arrays);
        result = spill_arrays(scene, arrays, STP_MESH_ARRAYS);
    }
    if (result == STP_OK) {
        stp_mesh_set_arrays(mesh, arrays);
        mesh->spilled = true;
    }
    return result;
}

stp_result stp_points_account(stp_scene* scene, uint32_t index)
{
    assert(index < scene->point_set_count);
    stp_point_set* points = &scene->point_sets[index];
    if (!points->spilled && !count_added(scene, stp_points_bytes(points))) {
        return STP_OK;
    }
    uint32_t found = index;
    stp_bulk_array arrays[STP_POINT_ARRAYS];
    points->content = stp_points_hash(points);
    stp_result result =
        stp_content_table_find(scene->context, &scene->spilled, points->content, index, &found);
    if (result == STP_OK && found != index) {
        stp_points_free_arrays(scene, points);
        stp_points_get_arrays(&scene->point_sets[found], arrays);
    } else if (result == STP_OK) {
        stp_points_get_arrays(points, arrays);
        result = points->spilled ? STP_OK : spill_arrays(scene, arrays, STP_POINT_ARRAYS);
    }
    if (result == STP_OK) {
        stp_points_set_arrays(points, arrays);
        points->spilled = true;
    }
    return result;
}

stp_result stp_texture_account(stp_scene* scene, uint32_t index)
{
    assert(index < scene->texture_count && !scene->textures[index].spilled);
    stp_texture* texture = &scene->textures[index];
    if (!count_added(scene, stp_texture_bytes(texture))) {
        return STP_OK;
    }
    uint32_t found = index;
    stp_bulk_array arrays[STP_TEXTURE_ARRAYS];
    texture->content = stp_texture_hash(texture);
    stp_result result =
        stp_content_table_find(scene->context, &scene->spilled, texture->content, index, &found);
    if (result == STP_OK && found != index) {
        stp_texture_free_arrays(scene, texture);
        stp_texture_get_arrays(&scene->textures[found], arrays);
        texture->encoding = scene->textures[found].encoding;
    } else if (result == STP_OK) {
        stp_texture_get_arrays(texture, arrays);
        result = spill_arrays(scene, arrays, STP_TEXTURE_ARRAYS);
    }
    if (result == STP_OK) {
        set_texture_arrays(texture, arrays);
        texture->spilled = true;
    }
    return result;
}
