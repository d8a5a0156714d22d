// SPDX-License-Identifier: MIT
#include "support_sample.h"

#include "base/math/position_grid.h"
#include "base/math/rng.h"
#include "base/splats/splat_codes.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

// Each draw is its own statement, because compilers may evaluate initialisers in any order.
typedef struct dice {
    stp_arena* arena;
    uint64_t seed, next;
    bool complete;
} dice;

static uint32_t below(dice* d, uint32_t bound)
{
    assert(bound > 0 && "there is a number below the bound");
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

// Random bytes; for optional columns NULL one time in three.
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
    bool empty = below(d, 7) == 0;
    int length = snprintf(buffer, sizeof(buffer), "%s \xc3\xa9 %u", what, below(d, 1000));
    length = empty ? 0 : length;
    const char* copy = stp_arena_copy_text(d->arena, buffer, (size_t)length);
    d->complete = d->complete && copy != NULL;
    return copy;
}

static stp_affine transform(dice* d)
{
    stp_affine t;
    for (int i = 0; i < 12; ++i) {
        t.m[i / 4][i % 4] = (double)number(d);
        t.m[i / 4][i % 4] += 1e-9 * below(d, 1000);
    }
    return t;
}

static stp_vec3 vector(dice* d)
{
    stp_vec3 v;
    v.x = number(d);
    v.y = number(d);
    v.z = number(d);
    return v;
}

static stp_vec3d vector_double(dice* d)
{
    return stp_to_double(vector(d));
}

static stp_box box(dice* d)
{
    stp_box made;
    made.min = vector(d);
    made.max = vector(d);
    return made;
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
        stp_store_mesh* mesh = &meshes[i];
        mesh->name = text(d, "mesh");
        mesh->vertex_count = vertices;
        mesh->triangle_count = triangles;
        mesh->material = below(d, content->directory.material_count);
        mesh->bounds = box(d);
        mesh->positions = numbers(d, 3 * (size_t)vertices, false);
        mesh->normals = column(d, 4 * (size_t)vertices, true);
        mesh->texcoords[0] = numbers(d, 2 * (size_t)vertices, true);
        mesh->texcoords[1] = numbers(d, 2 * (size_t)vertices, true);
        mesh->colors = column(d, 8 * (size_t)vertices, true);
        mesh->indices = indices;
    }
    content->meshes = meshes;
    content->directory.mesh_count = count;
}

static void add_points(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_point_set* sets = take(d, count, sizeof(*sets));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        stp_store_point_set* set = &sets[i];
        uint32_t points = below(d, 20);
        set->name = text(d, "points");
        set->point_count = points;
        set->material = below(d, content->directory.material_count);
        set->bounds = box(d);
        set->positions = numbers(d, 3 * (size_t)points, false);
        set->normals = column(d, 4 * (size_t)points, true);
        set->colors = column(d, 4 * (size_t)points, true);
    }
    content->point_sets = sets;
    content->directory.point_set_count = count;
}

static void add_textures(dice* d, stp_store_content* content, uint32_t count)
{
    stp_store_texture* textures = take(d, count, sizeof(*textures));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        stp_store_texture* texture = &textures[i];
        texture->width = 1 + below(d, 5);
        texture->height = 1 + below(d, 5);
        texture->wrap_u = below(d, 3);
        texture->wrap_v = below(d, 3);
        texture->nearest = below(d, 2);
        texture->texels = column(d, 4 * (size_t)texture->width * texture->height, false);
    }
    content->textures = textures;
    content->directory.texture_count = count;
}

static void add_options(dice* d, stp_splats* s)
{
    uint32_t* shapes = (s->columns & STP_SPLATS_SHAPES) != 0 ? take(d, s->count, 4) : NULL;
    uint32_t* ranges = (s->columns & STP_SPLATS_RANGES) != 0 ? take(d, s->count, 4) : NULL;
    for (uint32_t i = 0; shapes != NULL && i < s->count; ++i) {
        uint32_t larger = below(d, 0xFFF);
        shapes[i] = larger | below(d, larger + 1) << 12 | below(d, 256) << 24;
    }
    for (uint32_t i = 0; ranges != NULL && i < s->count; ++i) {
        uint32_t high = below(d, STP_RANGE_INFINITE + 1);
        ranges[i] = below(d, high + 1) | high << 16;
    }
    s->shapes = shapes;
    s->ranges = ranges;
}

static stp_splats make_splat_set(dice* d, uint32_t shading_count, uint32_t columns)
{
    stp_splats s = {.origin = vector(d), .columns = columns};
    s.step = below(d, 2) == 0 ? 0.0009765625f : 2.0f;
    s.candidate_radius = 0.01f * (float)below(d, 100);
    s.octave_count = below(d, 6);
    uint64_t entries = 0;
    for (uint32_t k = 0; k < s.octave_count; ++k) {
        s.count += 1 + below(d, 6u << k);
        s.octave_ends[k] = s.count;
        entries += (columns & STP_SPLATS_FLAT_COLORS) != 0 ? s.count - entries : s.count;
    }
    s.positions = column(d, 6 * (size_t)s.count, false);
    s.normals = column(d, 2 * (size_t)s.count, false);
    s.materials = column(d, s.count, false);
    for (uint32_t i = 0; s.materials != NULL && i < s.count; ++i) {
        s.materials[i] = (uint8_t)(s.materials[i] % shading_count);
    }
    s.colors = column(d, 3 * (size_t)entries, false);
    s.coverages = column(d, (size_t)entries, false);
    add_options(d, &s);
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

static void add_splat_sets(dice* d, stp_store_content* content, uint32_t count)
{
    stp_splats* sets = take(d, count, sizeof(*sets));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        sets[i] = make_splat_set(d, content->directory.shading_count, 0);
    }
    content->sets = sets;
    content->directory.set_count = count;
}

static stp_store_texture_use texture_use(dice* d, uint32_t texture_count)
{
    stp_store_texture_use use = {.texture = below(d, texture_count + 1)};
    use.texcoord = below(d, 2);
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
        stp_store_material* m = &materials[i];
        float* loose[] = {&m->base_color[0], &m->base_color[1], &m->base_color[2],
                          &m->base_color[3], &m->metallic,      &m->roughness,
                          &m->emissive[0],   &m->emissive[1],   &m->emissive[2],
                          &m->alpha_cutoff};
        m->name = text(d, "material");
        for (size_t k = 0; k < sizeof(loose) / sizeof(loose[0]); ++k) {
            *loose[k] = number(d);
        }
        m->alpha = (stp_store_alpha)below(d, 3);
        m->flags = below(d, 4);
        m->base_color_texture = texture_use(d, directory->texture_count);
        m->metallic_roughness_texture = texture_use(d, directory->texture_count);
        m->emissive_texture = texture_use(d, directory->texture_count);
    }
    for (uint32_t i = 0; d->complete && i < directory->shading_count; ++i) {
        stp_shading* shading = &shadings[i];
        shading->metallic = number(d);
        shading->roughness = number(d);
        for (int k = 0; k < 3; ++k) {
            shading->emissive[k] = number(d);
        }
        shading->flags = below(d, 4);
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
        node->first_edge = directory->edge_count;
        node->edge_count = edge_count;
        node->first_part = directory->part_count;
        node->part_count = part_count;
        node->set = below(d, directory->set_count + 1);
        node->flags = below(d, 2);
        node->triangle_count = stp_rng_hash(d->seed, d->next++);
        node->point_count = stp_rng_hash(d->seed, d->next++);
        node->bounds.min = vector_double(d);
        node->bounds.max = vector_double(d);
        node->set = node->set == directory->set_count ? STP_STORE_NONE : node->set;
        for (uint32_t k = 0; k < edge_count; ++k) {
            stp_store_edge* edge = &edges[directory->edge_count++];
            edge->node = below(d, i);
            edge->transform = transform(d);
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
        stp_store_object* object = &objects[i];
        object->name = text(d, "object");
        object->id = text(d, "id");
        object->parent = i == 0 || below(d, 4) == 0 ? STP_STORE_NONE : below(d, i);
        object->node =
            directory->node_count == 0 ? STP_STORE_NONE : below(d, directory->node_count);
        object->transform = transform(d);
    }
    directory->view_count = below(d, 3);
    directory->source_count = below(d, 3);
    for (uint32_t i = 0; d->complete && i < 2; ++i) {
        views[i].name = text(d, "view");
        views[i].eye = vector_double(d);
        views[i].target = vector_double(d);
        views[i].up = vector_double(d);
        views[i].fov_degrees = 55.5;
        sources[i].path = text(d, "path");
        sources[i].format = text(d, "format");
        sources[i].bytes = stp_rng_hash(d->seed, d->next++);
    }
    directory->objects = objects;
    directory->object_count = count;
    directory->views = views;
    directory->sources = sources;
}

// Sets of a second and third method for some nodes, with columns that the first does not have.
static void add_methods(dice* d, stp_store_content* content)
{
    stp_store_directory* directory = &content->directory;
    uint32_t nodes = directory->node_count, count = directory->set_count;
    stp_store_method* methods = take(d, 3, sizeof(*methods));
    stp_splats* sets = take(d, count + 2 * (size_t)nodes, sizeof(*sets));
    uint32_t* of_node = take(d, 2 * (size_t)nodes, sizeof(*of_node));
    if (!d->complete) {
        return;
    }
    for (uint32_t i = 0; i < count; ++i) {
        sets[i] = content->sets[i];
    }
    // the columns of version 1.2 when the golden file was written
    const uint32_t golden = STP_SPLATS_SHAPES | STP_SPLATS_RANGES | STP_SPLATS_FLAT_COLORS;
    methods[0] = (stp_store_method){.name = "blue", .id = STP_METHOD_BLUE, .set_count = count};
    for (uint32_t m = 1; m < 3; ++m) {
        methods[m] = (stp_store_method){.name = m == 1 ? "spt" : "stochastic",
                                        .id = m == 1 ? STP_METHOD_SPT : STP_METHOD_STOCHASTIC,
                                        .columns = m == 1 ? golden : below(d, 8),
                                        .first_set = count,
                                        .sets = of_node + (m - 1) * (size_t)nodes};
        for (uint32_t i = 0; i < nodes; ++i) {
            bool has = below(d, 2) == 0;
            of_node[(m - 1) * (size_t)nodes + i] = has ? count : STP_STORE_NONE;
            if (has) {
                sets[count++] = make_splat_set(d, directory->shading_count, methods[m].columns);
            }
        }
        methods[m].set_count = count - methods[m].first_set;
    }
    content->sets = sets;
    directory->set_count = count;
    directory->methods = methods;
    directory->method_count = 3;
}

// Keys for most sets and meshes, in most samples.
static void add_keys(dice* d, stp_store_content* content)
{
    const stp_store_directory* directory = &content->directory;
    uint32_t count = directory->set_count + directory->mesh_count;
    stp_hash* keys = take(d, count, sizeof(*keys));
    for (uint32_t i = 0; d->complete && i < count; ++i) {
        keys[i].low = below(d, 4) == 0 ? 0 : below(d, 3); // small, so that slots collide
        keys[i].high = keys[i].low == 0 ? 0 : stp_rng_hash(d->seed, d->next++);
    }
    content->set_keys = below(d, 4) == 0 ? NULL : keys;
    content->mesh_keys = below(d, 4) == 0 ? NULL : keys + directory->set_count;
}

// Without a census, the writer guesses one.
static void add_census(dice* d, stp_store_content* content)
{
    uint32_t count = 1 + below(d, 2), objects = content->directory.object_count;
    stp_store_census* census = take(d, 1, sizeof(*census));
    stp_store_census_part* parts = take(d, count, sizeof(*parts));
    uint32_t* members = take(d, 2 * (size_t)count, sizeof(*members));
    if (!d->complete || objects == 0 || below(d, 2) == 0) {
        return;
    }
    census->objects = below(d, 100);
    census->unique_objects = below(d, 100);
    census->instances = below(d, 100);
    census->part_count = count;
    census->parts = parts;
    for (uint32_t i = 0; i < count; ++i) {
        parts[i].name = text(d, "part");
        parts[i].member_count = 1 + below(d, 2);
        parts[i].members = members + 2 * (size_t)i;
        parts[i].objects = below(d, 50);
        for (uint32_t k = 0; k < parts[i].member_count; ++k) {
            members[2 * i + k] = below(d, objects);
        }
    }
    content->census = census;
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
    add_splat_sets(&d, &made.content, below(&d, 4));
    add_graph(&d, &made.content, below(&d, 6));
    add_objects(&d, &made.content, below(&d, 5));
    directory->unit_metres = below(&d, 2) == 0 ? 0.0 : 0.001;
    directory->up = (char)('x' + (int)below(&d, 3));
    directory->build_json = below(&d, 2) == 0 ? NULL : "{\"seed\": 0}";
    if ((stp_rng_hash(seed, 0x3E7) >> 12) % 2 != 0) {
        add_methods(&d, &made.content);
    }
    add_keys(&d, &made.content);
    add_census(&d, &made.content);
    made.complete = d.complete;
    return made;
}

bool sample_code_meshes(stp_arena* arena, sample* made, const double* steps)
{
    uint32_t count = made->content.directory.mesh_count;
    stp_coded_mesh* list = stp_arena_alloc_array(arena, (size_t)count + 1, sizeof(*list));
    for (uint32_t i = 0; list != NULL && i < count; ++i) {
        const stp_store_mesh* mesh = &made->content.meshes[i];
        list[i] = (stp_coded_mesh){0};
        if (i % 2 != 0) {
            continue;
        }
        double step = steps != NULL ? steps[i / 2]
                                    : stp_choose_grid_step(mesh->positions, mesh->indices,
                                                           mesh->triangle_count);
        stp_coded_mesh coded;
        if (stp_clusters_encode(arena->context, mesh, step, &coded) != STP_OK) {
            return false;
        }
        void* bytes = stp_arena_alloc(arena, coded.size);
        if (bytes != NULL) {
            memcpy(bytes, coded.bytes, coded.size);
            list[i] = coded;
            list[i].bytes = bytes;
        }
        stp_coded_mesh_destroy(arena->context, &coded);
        if (bytes == NULL) {
            return false;
        }
    }
    made->content.coded_meshes = list;
    return list != NULL;
}
