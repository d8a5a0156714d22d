// SPDX-License-Identifier: MIT
#include "builder/writer_input.h"

#include "base/splats/octahedral.h"
#include "store/bytes/format.h"

#include <assert.h>
#include <math.h>
#include <string.h>

#define BLOCK_SIZE ((size_t)64 << 10)
#define GRAIN 8192
#define FINE_STEP 0x1p-5 ///< maximum grid step of a set that holds points, in spacings

typedef struct normal_work {
    const float* from;
    int16_t* to;
} normal_work;

static void encode_normals(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const normal_work* work = user;
    stp_octahedral_encode16_many(work->from + 3 * begin, end - begin, work->to + 2 * begin);
}

// Normals in the file's format; NULL if there are none. `made` is false if memory runs out.
static const int16_t* convert_normals(stp_build_content* c, const float* normals, uint32_t count,
                                      bool* made)
{
    if (normals == NULL) {
        return NULL;
    }
    int16_t* out = STP_ARENA_ARRAY(&c->arena, int16_t, 2 * (size_t)count);
    *made = *made && out != NULL;
    if (out != NULL) {
        normal_work work = {normals, out};
        stp_parallel_for(c->context, count, GRAIN, encode_normals, &work);
    }
    return out;
}

// Triangles of these meshes are written as clusters (builder/meshes.h), with their own normals.
static bool convert_meshes(stp_build_content* c, const stp_scene* scene,
                           const stp_build_levels* levels)
{
    stp_store_mesh* meshes =
        STP_ARENA_ARRAY(&c->arena, stp_store_mesh, scene->mesh_count + levels->level_count);
    for (size_t i = 0; meshes != NULL && i < scene->mesh_count; ++i) {
        const stp_mesh* mesh = &scene->meshes[i];
        meshes[i] = (stp_store_mesh){
            .name = mesh->name,
            .vertex_count = mesh->vertex_count,
            .triangle_count = mesh->triangle_count,
            .material = mesh->material,
            .bounds = mesh->bounds,
            .positions = mesh->positions,
            .texcoords = {mesh->texcoords[0], mesh->texcoords[1]},
            .colors = mesh->colors,
            .indices = mesh->indices,
            .area = mesh->area,
        };
    }
    if (meshes != NULL && levels->level_count > 0) {
        memcpy(meshes + scene->mesh_count, levels->meshes, levels->level_count * sizeof(*meshes));
    }
    c->content.meshes = meshes;
    return meshes != NULL;
}

// Approximate distance between points of a set: from its evenly spread first ones (`blue`), or the
// coverage radius of all (a set made leaf by leaf).
static double spacing_of(const stp_splats* set)
{
    assert(set->count > 0 && "an empty set has no spacing");
    if (set->leaf_count > 0) {
        return (double)set->table.radius[set->table.size - 1];
    }
    return (double)set->paper_radius * sqrt((double)set->paper_count / (double)set->count);
}

// Whether a set contains all points of a node, at a precision well below their distance.
static bool holds_all(const stp_splats* set, const stp_point_set* points)
{
    bool is_of_points = set->columns == 0 || set->leaf_count > 0;
    return is_of_points && set->count != 0 && set->count == points->point_count &&
           (double)set->step <= FINE_STEP * spacing_of(set);
}

// Finds points that need no copy because a set holds them: its node has no other content, and no
// other node has them.
static bool find_held_points(stp_build_content* c, const stp_scene* scene,
                             stp_store_point_set* sets)
{
    const stp_store_directory* d = &c->content.directory;
    uint32_t* uses = STP_ARENA_ARRAY(&c->arena, uint32_t, scene->point_set_count + 1);
    if (uses == NULL) {
        return false;
    }
    memset(uses, 0, scene->point_set_count * sizeof(*uses));
    for (size_t i = 0; i < scene->node_part_count; ++i) {
        stp_part part = scene->node_parts[i];
        uses[part.kind == STP_PART_POINTS ? part.index : scene->point_set_count] += 1;
    }
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        stp_part part = node->part_count == 1 ? scene->node_parts[node->first_part] : (stp_part){0};
        uint32_t set = d->nodes[i].set;
        if (part.kind == STP_PART_POINTS && node->edge_count == 0 && uses[part.index] == 1 &&
            set != STP_STORE_NONE &&
            holds_all(&c->content.sets[set], &scene->point_sets[part.index])) {
            sets[part.index].held_by = set + 1;
        }
    }
    return true;
}

static bool convert_point_sets(stp_build_content* c, const stp_scene* scene)
{
    stp_store_point_set* sets =
        STP_ARENA_ARRAY(&c->arena, stp_store_point_set, scene->point_set_count);
    bool made = sets != NULL;
    for (size_t i = 0; made && i < scene->point_set_count; ++i) {
        const stp_point_set* set = &scene->point_sets[i];
        sets[i] = (stp_store_point_set){
            .name = set->name,
            .point_count = set->point_count,
            .material = set->material,
            .bounds = set->bounds,
            .positions = set->positions,
            .normals = convert_normals(c, set->normals, set->point_count, &made),
            .colors = set->colors,
        };
        for (int a = 0; a < STP_ATTRIBUTES; ++a) {
            sets[i].attributes[a] = set->attributes[a];
        }
    }
    c->content.point_sets = sets;
    return made && find_held_points(c, scene, sets);
}

static stp_store_texture_use convert_use(const stp_texture_use* use)
{
    stp_store_texture_use out = {.texture = use->texture, .texcoord = use->texcoord};
    memcpy(out.transform, use->transform, sizeof(out.transform));
    return out;
}

static bool convert_materials(stp_build_content* c, const stp_scene* scene,
                              const stp_build_levels* levels)
{
    stp_store_material* materials = STP_ARENA_ARRAY(&c->arena, stp_store_material,
                                                    scene->material_count + levels->material_count);
    for (size_t i = 0; materials != NULL && i < scene->material_count; ++i) {
        const stp_material* m = &scene->materials[i];
        stp_store_material* out = &materials[i];
        *out = (stp_store_material){
            .name = m->name,
            .metallic = m->metallic,
            .roughness = m->roughness,
            .alpha_cutoff = m->alpha_cutoff,
            .alpha = (stp_store_alpha)m->alpha_mode,
            .flags = (m->unlit ? STP_SHADING_UNLIT : 0u) |
                     (m->double_sided ? STP_SHADING_DOUBLE_SIDED : 0u) |
                     (m->front_only ? STP_SHADING_FRONT_ONLY : 0u),
            .inverted = m->inverted,
            .base_color_texture = convert_use(&m->base_color_texture),
            .metallic_roughness_texture = convert_use(&m->metallic_roughness_texture),
            .emissive_texture = convert_use(&m->emissive_texture),
            .normal_texture = convert_use(&m->normal_texture),
            .normal_scale = m->normal_texture.texture != STP_NONE ? m->normal_scale : 0.0f,
        };
        memcpy(out->base_color, m->base_color, sizeof(out->base_color));
        memcpy(out->emissive, m->emissive, sizeof(out->emissive));
    }
    if (materials != NULL && levels->material_count > 0) {
        memcpy(materials + scene->material_count, levels->materials,
               levels->material_count * sizeof(*materials));
    }
    c->content.directory.materials = materials;
    return materials != NULL;
}

static bool convert_textures(stp_build_content* c, const stp_scene* scene)
{
    stp_store_texture* textures =
        STP_ARENA_ARRAY(&c->arena, stp_store_texture, scene->texture_count);
    for (size_t i = 0; textures != NULL && i < scene->texture_count; ++i) {
        const stp_texture* t = &scene->textures[i];
        textures[i] = (stp_store_texture){.width = t->width,
                                          .height = t->height,
                                          .wrap_u = (uint32_t)t->wrap_u,
                                          .wrap_v = (uint32_t)t->wrap_v,
                                          .nearest = t->nearest,
                                          .texels = t->texels,
                                          .encoding = (uint32_t)t->encoding,
                                          .encoded = t->encoded,
                                          .encoded_size = t->encoded_size};
    }
    c->content.textures = textures;
    return textures != NULL;
}

// A node's set; none if it is empty because nothing is visible from outside.
static uint32_t find_set(const stp_build_content* c, const uint32_t* set_of_node, size_t node)
{
    uint32_t set = set_of_node != NULL ? set_of_node[node] : STP_STORE_NONE;
    assert(set == STP_STORE_NONE || set < c->content.directory.set_count);
    return set != STP_STORE_NONE && c->content.sets[set].count != 0 ? set : STP_STORE_NONE;
}

static bool convert_graph(stp_build_content* c, const stp_scene* scene, const uint32_t* set_of_node)
{
    stp_store_node* nodes = STP_ARENA_ARRAY(&c->arena, stp_store_node, scene->node_count);
    stp_store_edge* edges = STP_ARENA_ARRAY(&c->arena, stp_store_edge, scene->edge_count);
    stp_store_part* parts = STP_ARENA_ARRAY(&c->arena, stp_store_part, scene->node_part_count);
    if (nodes == NULL || edges == NULL || parts == NULL) {
        return false;
    }
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        nodes[i] = (stp_store_node){
            .first_edge = node->first_edge,
            .edge_count = node->edge_count,
            .first_part = node->first_part,
            .part_count = node->part_count,
            .set = find_set(c, set_of_node, i),
            .flags = node->flags & STP_OBJECT_MOVING,
            .triangle_count = node->triangle_count,
            .point_count = node->point_count,
            .bounds = node->bounds,
        };
    }
    for (size_t i = 0; i < scene->edge_count; ++i) {
        assert(scene->edges[i].node < scene->node_count);
        edges[i] =
            (stp_store_edge){.node = scene->edges[i].node, .transform = scene->edges[i].transform};
    }
    for (size_t i = 0; i < scene->node_part_count; ++i) {
        bool mesh = scene->node_parts[i].kind == STP_PART_MESH;
        parts[i] = (stp_store_part){.kind = mesh ? STP_STORE_PART_MESH : STP_STORE_PART_POINTS,
                                    .index = scene->node_parts[i].index};
    }
    c->content.directory.nodes = nodes;
    c->content.directory.edges = edges;
    c->content.directory.parts = parts;
    return true;
}

// A text too long for a file is replaced by its first name: PROJCS["name", ...
static bool convert_coordinates(stp_build_content* c, const char* text, const char** out)
{
    size_t length = text != NULL ? strlen(text) : 0;
    *out = length != 0 ? text : NULL;
    if (length <= STP_STORE_TEXT_LIMIT) {
        return true;
    }
    const char* begin = strchr(text, '"');
    size_t size = begin != NULL ? strcspn(begin + 1, "\"") : 0;
    size = size < STP_STORE_TEXT_LIMIT ? size : STP_STORE_TEXT_LIMIT;
    char* copy = size != 0 ? STP_ARENA_ARRAY(&c->arena, char, size + 1) : NULL;
    if (copy != NULL) {
        memcpy(copy, begin + 1, size);
        copy[size] = '\0';
    }
    assert((copy == NULL || strlen(copy) <= STP_STORE_TEXT_LIMIT) && "the writer refuses more");
    *out = copy;
    return size == 0 || copy != NULL;
}

static bool convert_names(stp_build_content* c, const stp_scene* scene)
{
    stp_store_object* objects = STP_ARENA_ARRAY(&c->arena, stp_store_object, scene->object_count);
    stp_store_view* views = STP_ARENA_ARRAY(&c->arena, stp_store_view, scene->view_count);
    stp_store_source* sources = STP_ARENA_ARRAY(&c->arena, stp_store_source, scene->source_count);
    if (objects == NULL || views == NULL || sources == NULL) {
        return false;
    }
    for (size_t i = 0; i < scene->object_count; ++i) {
        const stp_object* object = &scene->objects[i];
        objects[i] = (stp_store_object){.name = object->name,
                                        .id = object->id,
                                        .parent = object->parent,
                                        .node = object->node,
                                        .transform = object->transform};
        if ((object->flags & STP_OBJECT_PROTOTYPE) != 0) { // prototypes have no place of their own
            objects[i].parent = STP_STORE_NONE;
            objects[i].transform = (stp_affine){{{0}}};
        }
    }
    for (size_t i = 0; i < scene->view_count; ++i) {
        const stp_scene_view* view = &scene->views[i];
        views[i] = (stp_store_view){.name = view->name,
                                    .eye = view->eye,
                                    .target = view->target,
                                    .up = view->up,
                                    .fov_degrees = view->fov_degrees};
    }
    for (size_t i = 0; i < scene->source_count; ++i) {
        const stp_source* source = &scene->sources[i];
        sources[i] = (stp_store_source){
            .path = source->path, .format = source->format, .bytes = source->bytes};
        if (!convert_coordinates(c, source->coordinate_system, &sources[i].coordinate_system)) {
            return false;
        }
    }
    c->content.directory.objects = objects;
    c->content.directory.views = views;
    c->content.directory.sources = sources;
    return true;
}

static bool convert_counts(stp_store_directory* d, const stp_scene* scene,
                           const stp_build_levels* levels)
{
    size_t mesh_count = scene->mesh_count + levels->level_count;
    size_t material_count = scene->material_count + levels->material_count;
    size_t counts[] = {scene->node_count,   scene->edge_count,    scene->node_part_count,
                       scene->object_count, mesh_count,           scene->point_set_count,
                       material_count,      scene->texture_count, scene->view_count,
                       scene->source_count};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); ++i) {
        if (counts[i] >= STP_STORE_NONE) {
            return false;
        }
    }
    d->node_count = (uint32_t)scene->node_count;
    d->edge_count = (uint32_t)scene->edge_count;
    d->part_count = (uint32_t)scene->node_part_count;
    d->object_count = (uint32_t)scene->object_count;
    d->mesh_count = (uint32_t)mesh_count;
    d->point_set_count = (uint32_t)scene->point_set_count;
    d->material_count = (uint32_t)material_count;
    d->texture_count = (uint32_t)scene->texture_count;
    d->view_count = (uint32_t)scene->view_count;
    d->source_count = (uint32_t)scene->source_count;
    d->level_count = levels->level_count;
    d->level_cluster_count = levels->cluster_count;
    d->level_group_count = levels->group_count;
    d->levels = levels->levels;
    d->level_clusters = levels->clusters;
    d->level_groups = levels->groups;
    return true;
}

stp_result stp_build_content_create(const stp_scene* scene, const stp_splats* sets,
                                    uint32_t set_count, const uint32_t* set_of_node,
                                    const stp_build_levels* levels, stp_build_content* content)
{
    static const stp_build_levels none = {0};
    levels = levels != NULL ? levels : &none;
    *content = (stp_build_content){.context = scene->context,
                                   .arena = stp_arena_create(scene->context, BLOCK_SIZE)};
    stp_store_directory* d = &content->content.directory;
    content->content.sets = sets;
    d->set_count = set_count;
    d->root = scene->root;
    d->unit_metres = scene->unit_metres;
    d->up = scene->up[0];
    if (!convert_counts(d, scene, levels)) {
        return stp_fail(scene->context, STP_ERROR_LIMIT,
                        "the scene has more parts than a file can number");
    }
    bool made = convert_graph(content, scene, set_of_node) && convert_names(content, scene) &&
                convert_materials(content, scene, levels) && convert_textures(content, scene) &&
                convert_meshes(content, scene, levels) && convert_point_sets(content, scene);
    if (!made) {
        stp_build_content_destroy(content);
        return stp_fail_memory(scene->context);
    }
    return STP_OK;
}

stp_result stp_build_content_add_meshes(stp_build_content* content, const stp_scene* scene,
                                        const stp_build_meshes* meshes,
                                        const stp_build_levels* levels)
{
    size_t own = scene->mesh_count, count = own + levels->level_count;
    stp_coded_mesh* coded = STP_ARENA_ARRAY(&content->arena, stp_coded_mesh, count + 1);
    stp_hash* keys = STP_ARENA_ARRAY(&content->arena, stp_hash, count + 1);
    if (coded == NULL || keys == NULL) {
        return stp_fail_memory(content->context);
    }
    memset(keys, 0, count * sizeof(*keys));
    if (own > 0) {
        memcpy(coded, meshes->coded, own * sizeof(*coded));
        memcpy(keys, meshes->keys, own * sizeof(*keys));
    }
    if (levels->level_count > 0) {
        memcpy(coded + own, levels->coded, levels->level_count * sizeof(*coded));
        memcpy(keys + own, levels->keys, levels->level_count * sizeof(*keys));
    }
    content->content.coded_meshes = coded;
    content->content.mesh_keys = keys;
    return STP_OK;
}

void stp_build_content_destroy(stp_build_content* content)
{
    if (content->context != NULL) {
        stp_arena_destroy(&content->arena);
    }
    *content = (stp_build_content){0};
}
