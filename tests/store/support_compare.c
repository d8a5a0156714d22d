// SPDX-License-Identifier: MIT
#include "support_sample.h"

#include "base/splats/light_normal.h"
#include "store/clusters/clusters.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool same_text(const char* a, const char* b)
{
    return (a == NULL) == (b == NULL) && (a == NULL || strcmp(a, b) == 0);
}

static bool same_bytes(const void* a, const void* b, size_t size)
{
    return (a == NULL) == (b == NULL) && (size == 0 || a == NULL || memcmp(a, b, size) == 0);
}

static bool same_materials(const stp_store_directory* a, const stp_store_directory* b)
{
    for (uint32_t i = 0; i < a->material_count; ++i) {
        stp_store_material x = a->materials[i], y = b->materials[i];
        bool named = same_text(x.name, y.name);
        x.name = y.name = NULL;
        if (!named || memcmp(&x, &y, sizeof(x)) != 0) {
            return false;
        }
    }
    return same_bytes(a->shadings, b->shadings, a->shading_count * sizeof(stp_shading)) ||
           a->shading_count == 0;
}

static bool same_objects(const stp_store_directory* a, const stp_store_directory* b)
{
    for (uint32_t i = 0; i < a->object_count; ++i) {
        const stp_store_object *x = &a->objects[i], *y = &b->objects[i];
        if (!same_text(x->name, y->name) || !same_text(x->id, y->id) || x->parent != y->parent ||
            x->node != y->node || memcmp(&x->transform, &y->transform, sizeof(stp_affine)) != 0) {
            return false;
        }
    }
    for (uint32_t i = 0; i < a->view_count; ++i) {
        const stp_store_view *x = &a->views[i], *y = &b->views[i];
        if (!same_text(x->name, y->name) || memcmp(&x->eye, &y->eye, 3 * sizeof(x->eye)) != 0 ||
            memcmp(&x->fov_degrees, &y->fov_degrees, sizeof(double)) != 0) {
            return false;
        }
    }
    for (uint32_t i = 0; i < a->source_count; ++i) {
        const stp_store_source *x = &a->sources[i], *y = &b->sources[i];
        if (!same_text(x->path, y->path) || !same_text(x->format, y->format) ||
            x->bytes != y->bytes) {
            return false;
        }
    }
    return true;
}

static bool same_methods(const stp_store_directory* a, const stp_store_directory* b)
{
    bool same =
        a->method_count == b->method_count || (a->method_count == 0 && b->method_count == 1);
    for (uint32_t m = 0; same && m < a->method_count; ++m) {
        const stp_store_method *x = &a->methods[m], *y = &b->methods[m];
        same = strcmp(x->name, y->name) == 0 && x->id == y->id && x->columns == y->columns &&
               x->first_set == y->first_set && x->set_count == y->set_count &&
               (x->sets == NULL || memcmp(x->sets, y->sets, a->node_count * sizeof(*x->sets)) == 0);
    }
    return same;
}

static const char* directory_difference(const stp_store_directory* a, const stp_store_directory* b)
{
    if (a->node_count != b->node_count || a->edge_count != b->edge_count ||
        a->part_count != b->part_count || a->object_count != b->object_count ||
        a->material_count != b->material_count || a->shading_count != b->shading_count ||
        a->texture_count != b->texture_count || a->mesh_count != b->mesh_count ||
        a->point_set_count != b->point_set_count || a->set_count != b->set_count ||
        a->view_count != b->view_count || a->source_count != b->source_count ||
        !same_methods(a, b)) {
        return "counts";
    }
    if (a->root != b->root || a->up != b->up || !same_text(a->build_json, b->build_json) ||
        memcmp(&a->unit_metres, &b->unit_metres, sizeof(double)) != 0) {
        return "header";
    }
    for (uint32_t i = 0; i < a->edge_count; ++i) {
        if (a->edges[i].node != b->edges[i].node ||
            memcmp(&a->edges[i].transform, &b->edges[i].transform, sizeof(stp_affine)) != 0) {
            return "edges";
        }
    }
    if ((a->node_count != 0 &&
         !same_bytes(a->nodes, b->nodes, a->node_count * sizeof(*a->nodes))) ||
        (a->part_count != 0 &&
         !same_bytes(a->parts, b->parts, a->part_count * sizeof(*a->parts)))) {
        return "nodes or parts";
    }
    if (!same_materials(a, b)) {
        return "materials";
    }
    return same_objects(a, b) ? NULL : "objects, views or sources";
}

static bool same_mesh(const stp_store_mesh* a, stp_store* store, uint32_t index)
{
    stp_store_mesh b;
    if (stp_store_get_mesh(store, index, &b) != STP_OK) {
        return false;
    }
    size_t n = a->vertex_count;
    return same_text(a->name, b.name) && n == b.vertex_count &&
           a->triangle_count == b.triangle_count && a->material == b.material &&
           memcmp(&a->bounds, &b.bounds, sizeof(a->bounds)) == 0 &&
           same_bytes(a->positions, b.positions, 12 * n) &&
           same_bytes(a->normals, b.normals, 4 * n) &&
           same_bytes(a->texcoords[0], b.texcoords[0], 8 * n) &&
           same_bytes(a->texcoords[1], b.texcoords[1], 8 * n) &&
           same_bytes(a->colors, b.colors, 8 * n) &&
           same_bytes(a->indices, b.indices, 12 * (size_t)a->triangle_count);
}

static bool same_clusters(const stp_store_content* content, stp_store* store, uint32_t index)
{
    const stp_coded_mesh* a = &content->coded_meshes[index];
    const stp_store_mesh* mesh = &content->meshes[index];
    const stp_store_mesh* known = stp_store_describe_mesh(store, index);
    stp_clusters b;
    return stp_store_is_clustered(store, index) &&
           stp_store_get_clusters(store, index, &b) == STP_OK && a->size == b.size &&
           memcmp(a->bytes, b.bytes, a->size) == 0 && b.cluster_count == a->cluster_count &&
           same_text(mesh->name, known->name) && mesh->material == known->material &&
           known->vertex_count == a->vertex_count && known->triangle_count == a->triangle_count &&
           memcmp(&known->bounds, &a->bounds, sizeof(a->bounds)) == 0;
}

static bool same_points(const stp_store_point_set* a, stp_store* store, uint32_t index)
{
    stp_store_point_set b;
    if (stp_store_get_point_set(store, index, &b) != STP_OK) {
        return false;
    }
    size_t n = a->point_count;
    return same_text(a->name, b.name) && n == b.point_count && a->material == b.material &&
           memcmp(&a->bounds, &b.bounds, sizeof(a->bounds)) == 0 &&
           same_bytes(a->positions, b.positions, 12 * n) &&
           same_bytes(a->normals, b.normals, 4 * n) && same_bytes(a->colors, b.colors, 4 * n);
}

static bool same_texture(const stp_store_texture* a, stp_store* store, uint32_t index)
{
    stp_store_texture b;
    return stp_store_get_texture(store, index, &b) == STP_OK && a->width == b.width &&
           a->height == b.height && a->wrap_u == b.wrap_u && a->wrap_v == b.wrap_v &&
           a->nearest == b.nearest &&
           same_bytes(a->texels, b.texels, 4 * (size_t)a->width * a->height);
}

static bool same_splats(const stp_splats* a, stp_store* store, uint32_t index)
{
    stp_splats b;
    if (stp_store_get_splat_set(store, index, &b) != STP_OK) {
        return false;
    }
    size_t n = a->count, entries = 0;
    for (uint32_t k = 0; k < a->octave_count; ++k) {
        bool flat = (a->columns & STP_SPLATS_FLAT_COLORS) != 0;
        entries = flat ? a->octave_ends[k] : entries + a->octave_ends[k];
    }
    float scalars_a[] = {a->origin.x, a->origin.y,         a->origin.z,
                         a->step,     a->candidate_radius, a->paper_radius};
    float scalars_b[] = {b.origin.x, b.origin.y,         b.origin.z,
                         b.step,     b.candidate_radius, b.paper_radius};
    size_t lights = (size_t)stp_light_normals_begin(a, a->octave_count);
    return n == b.count && a->light_octaves == b.light_octaves &&
           (lights == 0 || (same_bytes(a->turns, b.turns, 2 * lights) &&
                            same_bytes(a->spreads, b.spreads, lights))) &&
           a->columns == b.columns && a->octave_count == b.octave_count &&
           a->paper_count == b.paper_count &&
           memcmp(scalars_a, scalars_b, sizeof(scalars_a)) == 0 &&
           memcmp(a->octave_ends, b.octave_ends, sizeof(a->octave_ends)) == 0 &&
           memcmp(&a->table, &b.table, sizeof(a->table)) == 0 &&
           (n == 0 ||
            (same_bytes(a->positions, b.positions, 6 * n) &&
             same_bytes(a->normals, b.normals, 2 * n) && same_bytes(a->materials, b.materials, n) &&
             same_bytes(a->colors, b.colors, 3 * entries) &&
             same_bytes(a->coverages, b.coverages, entries) &&
             same_bytes(a->shapes, b.shapes, 4 * n) && same_bytes(a->ranges, b.ranges, 4 * n) &&
             same_bytes(a->errors, b.errors, 4 * n)));
}

const char* sample_difference(const stp_store_content* content, stp_store* store)
{
    const stp_store_directory* directory = &content->directory;
    const char* difference = directory_difference(directory, stp_store_get_directory(store));
    for (uint32_t i = 0; difference == NULL && i < directory->mesh_count; ++i) {
        bool coded = content->coded_meshes != NULL && content->coded_meshes[i].bytes != NULL;
        bool same =
            coded ? same_clusters(content, store, i) : same_mesh(&content->meshes[i], store, i);
        difference = same ? NULL : "a mesh";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->point_set_count; ++i) {
        difference = same_points(&content->point_sets[i], store, i) ? NULL : "a point set";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->texture_count; ++i) {
        difference = same_texture(&content->textures[i], store, i) ? NULL : "a texture";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->set_count; ++i) {
        difference = same_splats(&content->sets[i], store, i) ? NULL : "a splat set";
    }
    return difference;
}

unsigned char* sample_read_file(const char* path, size_t* size)
{
    FILE* file = fopen(path, "rb");
    if (file == NULL) {
        return NULL;
    }
    fseek(file, 0, SEEK_END);
    long end = ftell(file);
    rewind(file);
    void* bytes = NULL;
    // exactly the file's size, so that sanitizers detect reads beyond it
    if (end >= 0 && posix_memalign(&bytes, 64, (size_t)end) == 0 &&
        fread(bytes, 1, (size_t)end, file) != (size_t)end) {
        free(bytes);
        bytes = NULL;
    }
    fclose(file);
    *size = end >= 0 ? (size_t)end : 0;
    return bytes;
}

stp_result sample_check(stp_context* context, const unsigned char* bytes, size_t size)
{
    stp_store* store = NULL;
    stp_store_check_report report;
    const stp_store_open_desc desc = {0};
    stp_result result = stp_store_open_memory(context, "memory", bytes, size, &desc, &store);
    if (result == STP_OK) {
        result = stp_store_check_open(store, false, &report);
        stp_store_close(store);
    }
    return result;
}
