// SPDX-License-Identifier: MIT
//
// 3MF, with the extensions for materials and production. Objects of the file become prototypes;
// items of the build and components of objects use them. Up is z.
#include "import/reading/smooth.h"
#include "import/reading/surface.h"
#include "import/threemf/threemf.h"

#include <assert.h>
#include <string.h>

enum { DEPTH_MAX = 256 }; // components within components

typedef struct wedge {
    uint32_t vertex;
    float texcoord[2];
    float color[4];
} wedge;

// A mesh in the making.
typedef struct builder {
    stp_3mf* m;
    const stp_3mf_object* object;
    stp_lookup known;
    wedge* wedges;
    uint32_t* indices;
    size_t count, capacity, index_count, index_capacity;
    uint32_t texture; ///< STP_NONE: none
    bool colored;
} builder;

static void free_builder(builder* b)
{
    stp_lookup_destroy(&b->known);
    stp_free(b->m->context, b->wedges);
    stp_free(b->m->context, b->indices);
}

static stp_result read_picture(stp_3mf* m, const stp_3mf_texture* texture, uint32_t* index)
{
    const stp_zip_entry* entry =
        texture->path != NULL ? stp_zip_find(&m->zip, texture->path) : NULL;
    *index = STP_NONE;
    if (entry == NULL) {
        stp_warn(m->context, "%s: \"%.200s\" is left out: it is not in the archive",
                 m->import->path, texture->path != NULL ? texture->path : "");
        return STP_OK;
    }
    unsigned char* bytes;
    size_t size;
    const char* reason;
    stp_result result = stp_zip_unpack(&m->zip, entry, &bytes, &size, &reason);
    if (result == STP_ERROR_OUT_OF_MEMORY) {
        return result;
    }
    if (result != STP_OK) {
        stp_warn(m->context, "%s: \"%.200s\" is left out: %s", m->import->path, texture->path,
                 reason);
        return STP_OK;
    }
    bool read;
    stp_texture picture = {
        .name = texture->path, .wrap_u = texture->wrap_u, .wrap_v = texture->wrap_v};
    result = stp_picture_decode(m->import, texture->path, bytes, size, &picture, &read);
    stp_free(m->context, bytes);
    return result == STP_OK && read ? stp_scene_add_texture(m->import->scene, &picture, index)
                                    : result;
}

// The material of a texture, or the plain one.
static stp_result find_material(stp_3mf* m, uint32_t texture, uint32_t* plain, uint32_t* material)
{
    if (texture == STP_NONE) {
        stp_result result = stp_add_plain_material(m->import, plain);
        *material = *plain;
        return result;
    }
    stp_3mf_texture* t = &m->textures[texture];
    stp_result result = STP_OK;
    if (t->material == STP_NONE) {
        stp_material made = stp_material_plain();
        result = read_picture(m, t, &made.base_color_texture.texture);
        result = result == STP_OK ? stp_scene_add_material(m->import->scene, &made, &t->material)
                                  : result;
    }
    *material = t->material;
    return result;
}

static stp_result add_wedge(builder* b, const wedge* w)
{
    stp_context* context = b->m->context;
    uint32_t fresh = (uint32_t)b->count, found;
    stp_result result = stp_lookup_add(&b->known, w, sizeof(*w), fresh, &found);
    if (result != STP_OK) {
        return result;
    }
    if (found == fresh) {
        if (!STP_MAKE_ROOM(context, b->wedges, b->capacity, b->count + 1)) {
            return stp_fail_memory(context);
        }
        b->wedges[b->count++] = *w;
    }
    if (!STP_MAKE_ROOM(context, b->indices, b->index_capacity, b->index_count + 1)) {
        return stp_fail_memory(context);
    }
    b->indices[b->index_count++] = found;
    return STP_OK;
}

static stp_result add_triangle(builder* b, const stp_3mf_triangle* t)
{
    const stp_3mf* m = b->m;
    const stp_3mf_group* group = t->group != STP_NONE ? &m->groups[t->group] : NULL;
    stp_result result = STP_OK;
    for (int i = 0; i < 3 && result == STP_OK; ++i) {
        wedge w = {.vertex = t->corners[i], .color = {1.0f, 1.0f, 1.0f, 1.0f}};
        if (group != NULL && t->values[i] < group->count) {
            const float* value = m->values[group->first + t->values[i]];
            bool texcoord = group->texture != STP_NONE;
            memcpy(texcoord ? w.texcoord : w.color, value, texcoord ? 8 : 16);
            b->colored = b->colored || !texcoord;
        }
        result = add_wedge(b, &w);
    }
    return result;
}

static stp_result end_mesh(builder* b, uint32_t* plain)
{
    stp_3mf* m = b->m;
    stp_context* context = m->context;
    stp_mesh mesh = {.vertex_count = (uint32_t)b->count,
                     .triangle_count = (uint32_t)(b->index_count / 3)};
    stp_result result = find_material(m, b->texture, plain, &mesh.material);
    if (result != STP_OK || b->index_count == 0) {
        return result;
    }
    bool textured = b->texture != STP_NONE;
    mesh.positions = STP_NEW_ARRAY(context, float, 3 * b->count);
    mesh.texcoords[0] = textured ? STP_NEW_ARRAY(context, float, 2 * b->count) : NULL;
    mesh.colors = b->colored ? STP_NEW_ARRAY(context, uint16_t, 4 * b->count) : NULL;
    if (mesh.positions == NULL || textured != (mesh.texcoords[0] != NULL) ||
        b->colored != (mesh.colors != NULL)) {
        stp_free(context, mesh.positions);
        stp_free(context, mesh.texcoords[0]);
        stp_free(context, mesh.colors);
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < b->count; ++i) {
        const wedge* w = &b->wedges[i];
        memcpy(mesh.positions + 3 * i, m->vertices[b->object->first_vertex + w->vertex],
               3 * sizeof(float));
        if (textured) {
            memcpy(mesh.texcoords[0] + 2 * i, w->texcoord, sizeof(w->texcoord));
        }
        for (size_t k = 0; k < 4 && b->colored; ++k) {
            float value = k < 3 ? stp_srgb_to_linear(w->color[k]) : w->color[k];
            mesh.colors[4 * i + k] = stp_unorm16(value);
        }
    }
    mesh.indices = b->indices;
    b->indices = NULL;
    stp_part part = {.kind = STP_PART_MESH};
    result = stp_import_add_mesh(m->import, &mesh, &part.index);
    return result == STP_OK ? stp_scene_add_part(m->import->scene, part) : result;
}

static uint32_t texture_of(const stp_3mf* m, const stp_3mf_triangle* t)
{
    return t->group != STP_NONE ? m->groups[t->group].texture : STP_NONE;
}

// Meshes of an object, one for each picture and one without.
typedef struct builders {
    builder* items;
    size_t count, capacity;
    size_t plain; ///< the one without a picture; SIZE_MAX: none
} builders;

static stp_result find_builder(stp_3mf* m, const stp_3mf_object* object, uint32_t texture,
                               builders* all, builder** found)
{
    size_t* number = texture != STP_NONE ? &m->textures[texture].builder : &all->plain;
    if (*number == SIZE_MAX) {
        if (!STP_MAKE_ROOM(m->context, all->items, all->capacity, all->count + 1)) {
            return stp_fail_memory(m->context);
        }
        all->items[all->count] = (builder){
            .m = m, .object = object, .known = {.context = m->context}, .texture = texture};
        *number = all->count++;
    }
    *found = &all->items[*number];
    assert((*found)->texture == texture);
    return STP_OK;
}

// Triangles with the same picture become a mesh.
static stp_result add_meshes(stp_3mf* m, const stp_3mf_object* object, uint32_t* plain)
{
    builders all = {.plain = SIZE_MAX};
    stp_result result = STP_OK;
    for (size_t i = 0; i < object->triangle_count && result == STP_OK; ++i) {
        const stp_3mf_triangle* t = &m->triangles[object->first_triangle + i];
        builder* b = NULL;
        result = find_builder(m, object, texture_of(m, t), &all, &b);
        result = result == STP_OK ? add_triangle(b, t) : result;
    }
    for (size_t i = 0; i < all.count; ++i) {
        builder* b = &all.items[i];
        result = result == STP_OK ? end_mesh(b, plain) : result;
        if (b->texture != STP_NONE) {
            m->textures[b->texture].builder = SIZE_MAX;
        }
        free_builder(b);
    }
    stp_free(m->context, all.items);
    return result;
}

static stp_result fail_use(const stp_3mf* m, const stp_3mf_use* use, const char* what)
{
    return stp_fail(m->context, STP_ERROR_FORMAT, "%s: %s: object %u %s", m->import->path,
                    m->models[use->model], use->id, what);
}

// Shows an object below `parent`.
static stp_result add_use(stp_3mf* m, const stp_3mf_use* use, uint32_t parent)
{
    const stp_3mf_object* target =
        &m->objects[stp_3mf_find(m, STP_3MF_OBJECT, use->model, use->id)];
    stp_object object = {.name = use->name != NULL ? use->name : target->name,
                         .parent = parent,
                         .transform = use->transform};
    stp_result result = stp_scene_add_object(m->import->scene, &object, NULL);
    assert(target->added != STP_NONE);
    return result == STP_OK ? stp_scene_add_use(m->import->scene, target->added) : result;
}

// Adds the object that a use names, after those that it uses itself.
static stp_result add_object(stp_3mf* m, const stp_3mf_use* use, uint32_t* plain, int depth)
{
    uint32_t index = stp_3mf_find(m, STP_3MF_OBJECT, use->model, use->id);
    if (index == STP_NONE) {
        return fail_use(m, use, "does not exist");
    }
    stp_3mf_object* object = &m->objects[index];
    if (object->added != STP_NONE) {
        return STP_OK;
    }
    if (object->open || depth > DEPTH_MAX) {
        return fail_use(m, use, object->open ? "contains itself" : "is nested too deeply");
    }
    object->open = true;
    stp_result result = STP_OK;
    const stp_3mf_use* uses = object->use_count > 0 ? m->uses + object->first_use : NULL;
    for (size_t i = 0; i < object->use_count && result == STP_OK; ++i) {
        result = add_object(m, &uses[i], plain, depth + 1);
    }
    object->open = false;
    stp_object added = {.name = object->name,
                        .parent = m->import->root,
                        .transform = stp_affine_identity(),
                        .flags = STP_OBJECT_PROTOTYPE};
    result =
        result == STP_OK ? stp_scene_add_object(m->import->scene, &added, &object->added) : result;
    result = result == STP_OK ? add_meshes(m, object, plain) : result;
    for (size_t i = 0; i < object->use_count && result == STP_OK; ++i) {
        result = add_use(m, &uses[i], object->added);
    }
    return result;
}

static stp_result add_items(stp_3mf* m)
{
    uint32_t plain = STP_NONE;
    stp_result result = STP_OK;
    for (size_t i = 0; i < m->item_count && result == STP_OK; ++i) {
        result = add_object(m, &m->items[i], &plain, 0);
        result = result == STP_OK ? add_use(m, &m->items[i], m->import->root) : result;
    }
    return result;
}

static stp_result read_package(stp_3mf* m)
{
    stp_result result = stp_zip_open(&m->zip, m->import);
    result = result == STP_OK ? stp_3mf_find_root(m) : result;
    for (; result == STP_OK && m->parsed < m->model_count; ++m->parsed) { // paths add models
        result = stp_3mf_parse(m, (uint32_t)m->parsed);
    }
    if (result != STP_OK) {
        return result;
    }
    stp_import_set_axes(m->import, 'z', m->unit_metres);
    if (m->item_count == 0) {
        stp_warn(m->context, "%s: is empty: its build has no items", m->import->path);
    }
    return add_items(m);
}

static stp_result read(stp_import* import)
{
    stp_3mf m = {.import = import,
                 .context = import->context,
                 .unit_metres = 0.001,
                 .names = {.context = import->context},
                 .paths = {.context = import->context},
                 .pictures = {.context = import->context}};
    stp_result result = read_package(&m);
    void* arrays[] = {m.models, m.objects, m.groups, m.textures, m.triangles,
                      m.uses,   m.items,   m.values, m.vertices};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(m.context, arrays[i]);
    }
    stp_lookup_destroy(&m.names);
    stp_lookup_destroy(&m.paths);
    stp_lookup_destroy(&m.pictures);
    stp_zip_close(&m.zip);
    return result;
}

const stp_importer stp_importer_3mf = {.name = "3mf", .extensions = "3mf", .read = read};
