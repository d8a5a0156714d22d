// SPDX-License-Identifier: MIT
#include "support_sample.h"

#include "base/rng.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct dice {
    stp_arena* arena;
    uint64_t seed, next;
    bool complete;
} dice;

static uint32_t below(dice* d, uint32_t bound)
{
    return stp_rng_below(d->seed, d->next++, bound);
}

static float number(dice* d)
{
    return (float)below(d, 20001) / 100.0f - 100.0f;
}

static void* take(dice* d, size_t count, size_t size)
{
    void* memory = stp_arena_alloc_array(d->arena, count + 1, size);
    if (memory == NULL) {
        d->complete = false;
    } else {
        memset(memory, 0, (count + 1) * size);
    }
    return memory;
}

// Random bytes; NULL, one time in three, where the column is optional.
static void* column(dice* d, size_t size, bool optional)
{
    if (optional && below(d, 3) == 0) {
        return NULL;
    }
    unsigned char* bytes = take(d, size, 1);
    for (size_t i = 0; bytes != NULL && i < size; ++i) {
        bytes[i] = (unsigned char)below(d, 256);
    }
    return bytes;
}

static float* numbers(dice* d, size_t count, bool optional)
{
    if (optional && below(d, 3) == 0) {
        return NULL;
    }
    float* values = take(d, count, sizeof(float));
    for (size_t i = 0; values != NULL && i < count; ++i) {
        values[i] = number(d);
    }
    return values;
}

static const char* text(dice* d, const char* what)
{
    char buffer[40];
    if (below(d, 5) == 0) {
        return NULL;
    }
    uint32_t suffix = below(d, 1000);
    bool is_empty = below(d, 7) == 0;
    int length = is_empty ? 0 : snprintf(buffer, sizeof(buffer), "%s \xc3\xa9 %u", what, suffix);
    const char* copy = stp_arena_copy_text(d->arena, buffer, (size_t)length);
    d->complete = d->complete && copy != NULL;
    return copy;
}

static stp_affine transform(dice* d)
{
    stp_affine t;
    for (int i = 0; i < 12; ++i) {
        t.m[i / 4][i % 4] = (double)number(d) + 1e-9 * below(d, 1000);
    }
    return t;
}

static stp_vec3d vector(dice* d)
{
    return (stp_vec3d){(double)number(d), (double)number(d), (double)number(d)};
}

static stp_box box(dice* d)
{
    return (stp_box){{number(d), number(d), number(d)}, {number(d), number(d), number(d)}};
}

static void add_meshes(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_mesh* meshes = take(d, count, sizeof(*meshes));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        uint32_t vertices = below(d, 12);
        uint32_t triangles = vertices == 0 ? 0 : below(d, 9);
        uint32_t* indices = take(d, 3 * (size_t)triangles, sizeof(uint32_t));
        for (uint32_t k = 0; indices != NULL && k < 3 * triangles; ++k) {
            indices[k] = below(d, vertices);
        }
        meshes[i] = (stp_store_mesh){
            .name = text(d, "mesh"),
            .vertex_count = vertices,
            .triangle_count = triangles,
            .material = below(d, content->directory.material_count),
            .bounds = box(d),
            .positions = numbers(d, 3 * (size_t)vertices, false),
            .normals = column(d, 4 * (size_t)vertices, true),
            .texcoords = {numbers(d, 2 * (size_t)vertices, true),
                          numbers(d, 2 * (size_t)vertices, true)},
            .colors = column(d, 8 * (size_t)vertices, true),
            .indices = indices,
        };
    }
    content->meshes = meshes;
    content->directory.mesh_count = count;
}

static void add_points(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_point_set* sets = take(d, count, sizeof(*sets));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        uint32_t points = below(d, 20);
        sets[i] = (stp_store_point_set){
            .name = text(d, "points"),
            .point_count = points,
            .material = below(d, content->directory.material_count),
            .bounds = box(d),
            .positions = numbers(d, 3 * (size_t)points, false),
            .normals = column(d, 4 * (size_t)points, true),
            .colors = column(d, 4 * (size_t)points, true),
        };
    }
    content->point_sets = sets;
    content->directory.point_set_count = count;
}

static void add_textures(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_texture* textures = take(d, count, sizeof(*textures));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        uint32_t width = 1 + below(d, 5), height = 1 + below(d, 5);
        textures[i] = (stp_store_texture){
            .width = width,
            .height = height,
            .wrap_u = below(d, 3),
            .wrap_v = below(d, 3),
            .nearest = below(d, 2),
            .texels = column(d, 4 * (size_t)width * height, false),
        };
    }
    content->textures = textures;
    content->directory.texture_count = count;
}

static stp_surfels make_surfels(dice* d, uint32_t shading_count)
{
    stp_surfels s = {
        .origin = {number(d), number(d), number(d)},
        .step = below(d, 2) == 0 ? 0.0009765625f : 2.0f,
        .candidate_radius = 0.01f * (float)below(d, 100),
        .octave_count = below(d, 6),
    };
    uint64_t entries = 0;
    for (uint32_t k = 0; k < s.octave_count; ++k) {
        s.count += 1 + below(d, 6u << k);
        s.octave_ends[k] = s.count;
        entries += s.count;
    }
    s.positions = column(d, 6 * (size_t)s.count, false);
    s.normals = column(d, 2 * (size_t)s.count, false);
    s.materials = column(d, s.count, false);
    for (uint32_t i = 0; s.materials != NULL && i < s.count; ++i) {
        s.materials[i] = (uint8_t)(s.materials[i] % shading_count);
    }
    s.colors = column(d, 3 * (size_t)entries, false);
    s.coverages = column(d, (size_t)entries, false);
    float radius = 64.0f;
    for (uint32_t at = 1; at <= s.count && s.table.size < STP_PREFIX_TABLE_SIZE;
         at += 1 + below(d, 9)) {
        s.table.count[s.table.size] = at;
        s.table.radius[s.table.size] = radius;
        s.table.size += 1;
        radius *= 1.0f - 0.01f * (float)below(d, 20);
    }
    s.paper_count = s.count / 2;
    s.paper_radius = s.paper_count != 0 ? radius : 0.0f;
    return s;
}

static void add_surfels(dice* d, stp_store_content* content, uint32_t count)
{
    stp_surfels* sets = take(d, count, sizeof(*sets));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        sets[i] = make_surfels(d, content->directory.shading_count);
    }
    content->surfels = sets;
    content->directory.surfels_count = count;
}

static stp_store_texture_use texture_use(dice* d, uint32_t texture_count)
{
    stp_store_texture_use use = {
        .texture = below(d, texture_count + 1),
        .texcoord = below(d, 2),
    };
    use.texture = use.texture == texture_count ? STP_STORE_NONE : use.texture;
    for (int i = 0; i < 6; ++i) {
        use.transform[i / 3][i % 3] = number(d);
    }
    return use;
}

static void add_materials(dice* d, stp_store_content* content)
{
    stp_store_directory* directory = &content->directory;
    stp_store_material* materials = take(d, directory->material_count, sizeof(*materials));
    stp_shading* shadings = take(d, directory->shading_count, sizeof(*shadings));
    for (uint32_t i = 0; d->complete && i < directory->material_count; ++i) {
        materials[i] = (stp_store_material){
            .name = text(d, "material"),
            .base_color = {number(d), number(d), number(d), number(d)},
            .metallic = number(d),
            .roughness = number(d),
            .emissive = {number(d), number(d), number(d)},
            .alpha_cutoff = number(d),
            .alpha = (stp_store_alpha)below(d, 3),
            .flags = below(d, 4),
            .base_color_texture = texture_use(d, directory->texture_count),
            .metallic_roughness_texture = texture_use(d, directory->texture_count),
            .emissive_texture = texture_use(d, directory->texture_count),
        };
    }
    for (uint32_t i = 0; d->complete && i < directory->shading_count; ++i) {
        shadings[i] = (stp_shading){
            number(d),
            number(d),
            {number(d), number(d), number(d)},
            below(d, 4),
        };
    }
    directory->materials = materials;
    directory->shadings = shadings;
}

static void add_graph(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_directory* directory = &content->directory;
    stp_store_node* nodes = take(d, count, sizeof(*nodes));
    stp_store_edge* edges = take(d, 3 * (size_t)count, sizeof(*edges));
    stp_store_part* parts = take(d, 2 * (size_t)count, sizeof(*parts));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        uint32_t edge_count = i == 0 ? 0 : below(d, 4), part_count = below(d, 3);
        stp_store_node* node = &nodes[i];
        *node = (stp_store_node){
            .first_edge = directory->edge_count,
            .edge_count = edge_count,
            .first_part = directory->part_count,
            .part_count = part_count,
            .surfels = below(d, directory->surfels_count + 1),
            .flags = below(d, 2),
            .triangle_count = stp_rng_hash(d->seed, d->next++),
            .point_count = stp_rng_hash(d->seed, d->next++),
            .bounds = {vector(d), vector(d)},
        };
        node->surfels = node->surfels == directory->surfels_count ? STP_STORE_NONE : node->surfels;
        for (uint32_t k = 0; k < edge_count; ++k) {
            edges[directory->edge_count++] = (stp_store_edge){below(d, i), transform(d)};
        }
        for (uint32_t k = 0; k < part_count; ++k) {
            bool points =
                directory->point_set_count != 0 && (below(d, 3) == 0 || directory->mesh_count == 0);
            uint32_t bound = points ? directory->point_set_count : directory->mesh_count;
            if (bound == 0) {
                node->part_count = 0;
                break;
            }
            parts[directory->part_count++] = (stp_store_part){
                points ? STP_STORE_PART_POINTS : STP_STORE_PART_MESH, below(d, bound)};
        }
    }
    directory->nodes = nodes;
    directory->edges = edges;
    directory->parts = parts;
    directory->node_count = count;
    directory->root = count == 0 ? STP_STORE_NONE : count - 1;
}

static void add_objects(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_directory* directory = &content->directory;
    stp_store_object* objects = take(d, count, sizeof(*objects));
    stp_store_view* views = take(d, 2, sizeof(*views));
    stp_store_source* sources = take(d, 2, sizeof(*sources));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        objects[i] = (stp_store_object){
            .name = text(d, "object"),
            .id = text(d, "id"),
            .parent = i == 0 || below(d, 4) == 0 ? STP_STORE_NONE : below(d, i),
            .node = directory->node_count == 0 ? STP_STORE_NONE : below(d, directory->node_count),
            .transform = transform(d),
        };
    }
    directory->view_count = below(d, 3);
    directory->source_count = below(d, 3);
    for (uint32_t i = 0; d->complete && i < 2; ++i) {
        views[i] = (stp_store_view){text(d, "view"), vector(d), vector(d), vector(d), 55.5};
        sources[i] = (stp_store_source){text(d, "path"), text(d, "format"),
                                        stp_rng_hash(d->seed, d->next++)};
    }
    directory->objects = objects;
    directory->object_count = count;
    directory->views = views;
    directory->sources = sources;
}

sample sample_make(stp_arena* arena, uint64_t seed)
{
    dice d = {.arena = arena, .seed = seed, .complete = true};
    sample made = {0};
    stp_store_directory* directory = &made.content.directory;
    directory->material_count = 1 + below(&d, 3);
    directory->shading_count = 1 + below(&d, 3);
    add_textures(&d, &made.content, below(&d, 3));
    add_materials(&d, &made.content);
    add_meshes(&d, &made.content, below(&d, 4));
    add_points(&d, &made.content, below(&d, 3));
    add_surfels(&d, &made.content, below(&d, 4));
    add_graph(&d, &made.content, below(&d, 6));
    add_objects(&d, &made.content, below(&d, 5));
    directory->unit_metres = below(&d, 2) == 0 ? 0.0 : 0.001;
    directory->up = (char)('x' + (int)below(&d, 3));
    directory->build_json = below(&d, 2) == 0 ? NULL : "{\"seed\": 0}";
    made.complete = d.complete;
    return made;
}

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

static const char* directory_difference(const stp_store_directory* a, const stp_store_directory* b)
{
    if (a->node_count != b->node_count || a->edge_count != b->edge_count ||
        a->part_count != b->part_count || a->object_count != b->object_count ||
        a->material_count != b->material_count || a->shading_count != b->shading_count ||
        a->texture_count != b->texture_count || a->mesh_count != b->mesh_count ||
        a->point_set_count != b->point_set_count || a->surfels_count != b->surfels_count ||
        a->view_count != b->view_count || a->source_count != b->source_count) {
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

static bool same_surfels(const stp_surfels* a, stp_store* store, uint32_t index)
{
    stp_surfels b;
    if (stp_store_get_surfels(store, index, &b) != STP_OK) {
        return false;
    }
    size_t n = a->count, entries = 0;
    for (uint32_t k = 0; k < a->octave_count; ++k) {
        entries += a->octave_ends[k];
    }
    float scalars_a[] = {a->origin.x, a->origin.y,         a->origin.z,
                         a->step,     a->candidate_radius, a->paper_radius};
    float scalars_b[] = {b.origin.x, b.origin.y,         b.origin.z,
                         b.step,     b.candidate_radius, b.paper_radius};
    return n == b.count && a->octave_count == b.octave_count && a->paper_count == b.paper_count &&
           memcmp(scalars_a, scalars_b, sizeof(scalars_a)) == 0 &&
           memcmp(a->octave_ends, b.octave_ends, sizeof(a->octave_ends)) == 0 &&
           memcmp(&a->table, &b.table, sizeof(a->table)) == 0 &&
           (n == 0 ||
            (same_bytes(a->positions, b.positions, 6 * n) &&
             same_bytes(a->normals, b.normals, 2 * n) && same_bytes(a->materials, b.materials, n) &&
             same_bytes(a->colors, b.colors, 3 * entries) &&
             same_bytes(a->coverages, b.coverages, entries)));
}

const char* sample_difference(const stp_store_content* content, stp_store* store)
{
    const stp_store_directory* directory = &content->directory;
    const char* difference = directory_difference(directory, stp_store_get_directory(store));
    for (uint32_t i = 0; difference == NULL && i < directory->mesh_count; ++i) {
        difference = same_mesh(&content->meshes[i], store, i) ? NULL : "a mesh";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->point_set_count; ++i) {
        difference = same_points(&content->point_sets[i], store, i) ? NULL : "a point set";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->texture_count; ++i) {
        difference = same_texture(&content->textures[i], store, i) ? NULL : "a texture";
    }
    for (uint32_t i = 0; difference == NULL && i < directory->surfels_count; ++i) {
        difference = same_surfels(&content->surfels[i], store, i) ? NULL : "a surfel set";
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
    // exactly as large as the file, so that sanitizers see a read beyond it
    if (end >= 0 && posix_memalign(&bytes, 64, (size_t)end) == 0 &&
        fread(bytes, 1, (size_t)end, file) != (size_t)end) {
        free(bytes);
        bytes = NULL;
    }
    fclose(file);
    *size = end >= 0 ? (size_t)end : 0;
    return bytes;
}
