// SPDX-License-Identifier: MIT
#include "builder/build_levels.h"

#include "base/core/gate.h"
#include "builder/stored_levels.h"

#include <assert.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

// Part of every key: increase when the same triangles give other levels.
static const char* const code_version = "stipple-levels-6";

#define BYTES_EACH 400     // memory for a triangle, roughly
#define COPIES 2.0         // triangles of levels for each one of the meshes
#define OTHERS_SHARE 0.125 // triangles of a node that levels do not replace, at most
#define LARGE_SHARE 2      // nodes with more than this part of a thread's share run on all threads

enum { MET_BEFORE = 1, MET_NOW = 2 };

/// A node that may have levels.
typedef struct source {
    uint32_t node, triangles;
    stp_placed_part* parts; ///< of the node and all below it; owned
    size_t part_count;
    stp_hash key;
} source;

typedef struct run {
    const stp_scene* scene;
    const stp_build_levels_desc* desc;
    stp_capture_textures* textures;
    source* sources; ///< large ones first
    uint32_t source_count, large_count;
    stp_stored_levels* stored; ///< by source
    stp_gate* gate;
    pthread_mutex_t mutex;          ///< guards the result and the count
    pthread_mutex_t previous_mutex; ///< a store allows one thread at a time
    stp_result result;              ///< the first failure
    uint32_t made;                  ///< sources whose levels were made
} run;

/// Everything that determines the levels of a node: its content, which materials share shadings,
/// and the grids of its meshes.
static stp_hash make_key(const run* r, const source* from)
{
    const stp_node* n = &r->scene->nodes[from->node];
    stp_hash key = stp_hash_bytes((stp_hash){0}, code_version, strlen(code_version));
    key = stp_hash_bytes(key, &n->content, sizeof(n->content));
    for (size_t i = 0; i < from->part_count; ++i) {
        const stp_mesh* mesh = &r->scene->meshes[from->parts[i].part.index];
        uint8_t shading = r->desc->shading_of_material[mesh->material];
        key = stp_hash_bytes(key, &shading, sizeof(shading));
        key = stp_hash_bytes(key, &mesh->grid_step, sizeof(mesh->grid_step));
    }
    return key;
}

static int compare_sources(const void* left, const void* right)
{
    const source *a = left, *b = right;
    if (a->triangles != b->triangles) {
        return a->triangles > b->triangles ? -1 : 1;
    }
    return a->node < b->node ? -1 : a->node > b->node ? 1 : 0;
}

/// Whether levels of a node are worth it: few of its triangles are not opaque, and few are copies
/// of others, for which levels are made as well. `met`: per mesh, whether it has levels.
static bool is_worth(const stp_scene* scene, source* from, uint8_t* met)
{
    uint64_t opaque = 0, others = 0, fresh = 0;
    for (size_t i = 0; i < from->part_count; ++i) {
        stp_part part = from->parts[i].part;
        if (part.kind != STP_PART_MESH || from->parts[i].flags != 0) {
            return false;
        }
        uint64_t count = scene->meshes[part.index].triangle_count;
        bool replaced = stp_levels_replace(scene, part);
        opaque += replaced ? count : 0;
        others += replaced ? 0 : count;
    }
    for (size_t i = 0; i < from->part_count; ++i) {
        uint32_t mesh = from->parts[i].part.index;
        fresh += met[mesh] == 0 ? scene->meshes[mesh].triangle_count : 0;
        met[mesh] |= MET_NOW;
    }
    bool good = opaque >= STP_LEVELS_LEAST && (double)opaque <= COPIES * (double)fresh &&
                (double)others <= OTHERS_SHARE * (double)opaque;
    for (size_t i = 0; i < from->part_count; ++i) {
        uint8_t* state = &met[from->parts[i].part.index];
        *state = good || (*state & MET_BEFORE) != 0 ? MET_BEFORE : 0;
    }
    from->triangles = (uint32_t)opaque;
    return good;
}

/// Adds a node as a source if its levels are worth it.
static stp_result try_node(run* r, uint32_t node, uint8_t* met, bool* added)
{
    const stp_scene* scene = r->scene;
    const stp_node* n = &scene->nodes[node];
    source from = {.node = node};
    *added = false;
    if (n->triangle_count < STP_LEVELS_LEAST || n->triangle_count > STP_LEVELS_MOST ||
        n->point_count != 0) {
        return STP_OK;
    }
    stp_result result =
        stp_scene_flatten(scene, node, STP_LEVELS_MOST, &from.parts, &from.part_count);
    if (result == STP_OK && is_worth(scene, &from, met)) {
        from.key = make_key(r, &from);
        r->sources[r->source_count++] = from;
        *added = true;
        return STP_OK;
    }
    stp_free(scene->context, from.parts);
    return result;
}

/// Finds the uppermost nodes whose levels are worth it.
static stp_result find_sources(run* r)
{
    const stp_scene* scene = r->scene;
    uint8_t* reached = STP_NEW_ZEROED(scene->context, uint8_t, scene->node_count + 1);
    uint8_t* met = STP_NEW_ZEROED(scene->context, uint8_t, scene->mesh_count + 1);
    stp_result result = reached != NULL && met != NULL ? STP_OK : stp_fail_memory(scene->context);
    if (result == STP_OK && scene->root < scene->node_count) {
        reached[scene->root] = 1;
    }
    for (uint32_t i = (uint32_t)scene->node_count; i-- > 0 && result == STP_OK;) {
        bool added = false;
        if (reached[i] == 0) {
            continue;
        }
        result = try_node(r, i, met, &added);
        const stp_node* n = &scene->nodes[i];
        for (uint32_t k = 0; k < n->edge_count && !added; ++k) {
            reached[scene->edges[n->first_edge + k].node] = 1;
        }
    }
    stp_free(scene->context, reached);
    stp_free(scene->context, met);
    return result;
}

static stp_result list_sources(run* r)
{
    const stp_scene* scene = r->scene;
    uint64_t total = 0;
    r->sources = STP_NEW_ARRAY(scene->context, source, scene->node_count + 1);
    stp_result result = r->sources != NULL ? find_sources(r) : stp_fail_memory(scene->context);
    if (result != STP_OK) {
        return result;
    }
    for (uint32_t i = 0; i < r->source_count; ++i) {
        total += r->sources[i].triangles;
    }
    if (r->source_count > 0) {
        qsort(r->sources, r->source_count, sizeof(*r->sources), compare_sources);
    }
    uint64_t threads = stp_context_thread_count(scene->context);
    while (r->large_count < r->source_count &&
           LARGE_SHARE * threads * r->sources[r->large_count].triangles > total) {
        r->large_count += 1;
    }
    r->stored = STP_NEW_ZEROED(scene->context, stp_stored_levels, (size_t)r->source_count + 1);
    return r->stored != NULL ? STP_OK : stp_fail_memory(scene->context);
}

/// Whether the levels of a node are in the work folder, or in an earlier output.
static bool find_levels(run* r, uint32_t index)
{
    const stp_build_levels_desc* desc = r->desc;
    stp_hash key = r->sources[index].key;
    if (stp_work_find_levels(desc->work, key, desc->shading_count, &r->stored[index])) {
        return true;
    }
    pthread_mutex_lock(&r->previous_mutex);
    bool taken =
        desc->previous != NULL &&
        stp_previous_output_take_levels(desc->previous, key, desc->shading_count, desc->work);
    pthread_mutex_unlock(&r->previous_mutex);
    return taken && stp_work_find_levels(desc->work, key, desc->shading_count, &r->stored[index]);
}

static stp_result make_source(const run* r, const source* s)
{
    stp_gate_ticket ticket;
    stp_node_levels levels;
    stp_result result = stp_gate_enter(r->gate, BYTES_EACH * (uint64_t)s->triangles, &ticket);
    if (result == STP_OK) {
        result = stp_node_levels_make(r->scene, s->parts, s->part_count,
                                      r->desc->shading_of_material, r->textures, &levels);
        result = result == STP_OK
                     ? stp_work_store_levels(r->scene->context, r->desc->work, s->key, &levels)
                     : result;
        stp_node_levels_destroy(r->scene->context, &levels);
        stp_gate_leave(r->gate, &ticket);
    }
    return result;
}

static void run_source(run* r, uint32_t index)
{
    const source* s = &r->sources[index];
    stp_result result = STP_OK;
    uint32_t made = 0;
    if (find_levels(r, index)) {
        stp_progress_add(r->scene->context, s->triangles);
        return;
    }
    // an invalid result under the key is dropped the first time; the second attempt succeeds
    for (bool found = false; made < 2 && result == STP_OK && !found; ++made) {
        result = make_source(r, s);
        found = result == STP_OK && stp_work_find_levels(r->desc->work, s->key,
                                                         r->desc->shading_count, &r->stored[index]);
    }
    if (result == STP_OK &&
        !stp_work_find_levels(r->desc->work, s->key, r->desc->shading_count, &r->stored[index])) {
        result = stp_fail(r->scene->context, STP_ERROR_IO,
                          "levels cannot be read back from the work folder");
    }
    stp_progress_add(r->scene->context, s->triangles);
    pthread_mutex_lock(&r->mutex);
    r->result = r->result == STP_OK ? result : r->result;
    r->made += 1;
    pthread_mutex_unlock(&r->mutex);
    if (result != STP_OK) {
        stp_parallel_stop(r->scene->context);
    }
}

static void run_small(size_t begin, size_t end, uint32_t worker, void* user)
{
    run* r = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        run_source(r, r->large_count + (uint32_t)i);
    }
}

static stp_result run_all(run* r)
{
    stp_context* context = r->scene->context;
    stp_loop_report report = {.stage = "levels", .unit = "triangles"};
    for (uint32_t i = r->large_count; i < r->source_count; ++i) {
        report.total += r->sources[i].triangles;
    }
    for (uint32_t i = 0; i < r->large_count && r->result == STP_OK; ++i) {
        stp_result result = stp_progress(context, "levels", (double)i / r->source_count);
        r->result = r->result == STP_OK ? result : r->result;
        if (r->result == STP_OK) {
            run_source(r, i);
        }
    }
    uint32_t left = r->source_count - r->large_count;
    if (r->result != STP_OK || left == 0) {
        return r->result;
    }
    stp_result result = stp_parallel_for_reported(context, left, 1, run_small, r, &report);
    return r->result == STP_OK ? result : r->result;
}

// By node.
static int compare_nodes(const void* left, const void* right)
{
    const source *a = *(const source*const*)left, *b = *(const source*const*)right;
    return a->node < b->node ? -1 : a->node > b->node ? 1 : 0;
}

static stp_result allocate(stp_context* context, const run* r, stp_build_levels* l)
{
    uint64_t levels = 0, clusters = 0, groups = 0;
    for (uint32_t i = 0; i < r->source_count; ++i) {
        levels += r->stored[i].level_count;
        clusters += r->stored[i].cluster_count;
        groups += r->stored[i].level_count > 0 ? r->stored[i].group_count : 0;
    }
    if (levels >= UINT32_MAX || clusters >= UINT32_MAX || groups >= UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "the scene has more levels than a file can number");
    }
    l->levels = STP_NEW_ZEROED(context, stp_store_level, (size_t)levels + 1);
    l->clusters = STP_NEW_ARRAY(context, stp_store_level_cluster, (size_t)clusters + 1);
    l->groups = STP_NEW_ARRAY(context, stp_store_level_group, (size_t)groups + 1);
    l->meshes = STP_NEW_ZEROED(context, stp_store_mesh, (size_t)levels + 1);
    l->coded = STP_NEW_ZEROED(context, stp_coded_mesh, (size_t)levels + 1);
    l->keys = STP_NEW_ARRAY(context, stp_hash, (size_t)levels + 1);
    l->materials = STP_NEW_ZEROED(context, stp_store_material, STP_SHADING_LIMIT);
    bool good = l->levels != NULL && l->clusters != NULL && l->groups != NULL &&
                l->meshes != NULL && l->coded != NULL && l->keys != NULL && l->materials != NULL;
    return good ? STP_OK : stp_fail_memory(context);
}

/// The material of a shading, white.
static uint32_t find_material(const run* r, uint8_t shading, uint32_t of_shading[],
                              stp_build_levels* l)
{
    if (of_shading[shading] == STP_NONE) {
        const stp_shading* from = &r->desc->shadings[shading];
        stp_store_material* to = &l->materials[l->material_count];
        const stp_store_texture_use none = {.texture = STP_STORE_NONE};
        *to = (stp_store_material){
            .base_color = {1.0f, 1.0f, 1.0f, 1.0f},
            .metallic = from->metallic,
            .roughness = from->roughness,
            .emissive = {from->emissive[0], from->emissive[1], from->emissive[2]},
            .flags = from->flags &
                     (STP_SHADING_UNLIT | STP_SHADING_DOUBLE_SIDED | STP_SHADING_FRONT_ONLY),
            .base_color_texture = none,
            .metallic_roughness_texture = none,
            .emissive_texture = none,
        };
        of_shading[shading] = (uint32_t)r->scene->material_count + l->material_count++;
    }
    return of_shading[shading];
}

static void add_node(const run* r, uint32_t index, uint32_t of_shading[], stp_build_levels* l)
{
    const stp_stored_levels* stored = &r->stored[index];
    uint32_t first_group = l->group_count;
    for (uint32_t i = 0; i < stored->group_count && stored->level_count > 0; ++i) {
        float g[5];
        stp_stored_level_group(stored, i, g);
        l->groups[l->group_count++] = (stp_store_level_group){{g[0], g[1], g[2]}, g[3], g[4]};
    }
    for (uint32_t i = 0; i < stored->cluster_count; ++i) {
        uint32_t c[3];
        stp_stored_level_cluster(stored, i, c);
        l->clusters[l->cluster_count++] = (stp_store_level_cluster){
            .made_by = c[0] != STP_LEVEL_NONE ? first_group + c[0] : STP_STORE_NONE,
            .used_by = c[1] != STP_LEVEL_NONE ? first_group + c[1] : STP_STORE_NONE,
            .one_sided = c[2]};
    }
    for (uint32_t i = 0; i < stored->level_count; ++i) {
        stp_stored_level level = stp_stored_level_at(stored, i);
        l->levels[l->level_count] = (stp_store_level){
            .node = r->sources[index].node,
            .flags = stored->from_outside ? (uint32_t)STP_LEVEL_FROM_OUTSIDE : 0u};
        l->coded[l->level_count] = level.coded;
        l->keys[l->level_count] = stp_level_key(r->sources[index].key, i, level.shading);
        l->meshes[l->level_count] =
            (stp_store_mesh){.vertex_count = level.coded.vertex_count,
                             .triangle_count = level.coded.triangle_count,
                             .material = find_material(r, level.shading, of_shading, l),
                             .bounds = level.coded.bounds,
                             .area = level.area};
        l->level_count += 1;
    }
}

static stp_result collect(const run* r, stp_build_levels* l)
{
    stp_context* context = r->scene->context;
    uint32_t of_shading[STP_SHADING_LIMIT];
    memset(of_shading, 0xff, sizeof(of_shading));
    const source** order = STP_NEW_ARRAY(context, const source*, (size_t)r->source_count + 1);
    stp_result result = order != NULL ? allocate(context, r, l) : stp_fail_memory(context);
    for (uint32_t i = 0; i < r->source_count && result == STP_OK; ++i) {
        order[i] = &r->sources[i];
    }
    if (result == STP_OK) {
        qsort(order, r->source_count, sizeof(*order), compare_nodes);
    }
    for (uint32_t i = 0; i < r->source_count && result == STP_OK; ++i) {
        add_node(r, (uint32_t)(order[i] - r->sources), of_shading, l);
    }
    stp_free(context, order);
    return result;
}

stp_result stp_build_levels_make(const stp_scene* scene, const stp_build_levels_desc* desc,
                                 stp_build_levels* levels)
{
    run r = {.scene = scene, .desc = desc};
    *levels = (stp_build_levels){0};
    pthread_mutex_init(&r.mutex, NULL);
    pthread_mutex_init(&r.previous_mutex, NULL);
    r.result = list_sources(&r);
    if (r.result == STP_OK && r.source_count > 0) {
        r.result = stp_gate_create(scene->context, desc->memory_bytes, &r.gate);
        r.result =
            r.result == STP_OK ? stp_capture_textures_create(scene, true, &r.textures) : r.result;
        r.result = r.result == STP_OK ? run_all(&r) : r.result;
        r.result = r.result == STP_OK ? collect(&r, levels) : r.result;
        levels->made = r.made;
        levels->found = r.source_count - r.made;
    }
    stp_capture_textures_destroy(r.textures);
    stp_gate_destroy(r.gate);
    pthread_mutex_destroy(&r.previous_mutex);
    pthread_mutex_destroy(&r.mutex);
    for (uint32_t i = 0; i < r.source_count; ++i) {
        stp_free(scene->context, r.sources[i].parts);
    }
    stp_free(scene->context, r.sources);
    stp_free(scene->context, r.stored);
    if (r.result != STP_OK) {
        stp_build_levels_destroy(scene->context, levels);
    }
    return r.result;
}

void stp_build_levels_destroy(stp_context* context, stp_build_levels* levels)
{
    stp_free(context, levels->levels);
    stp_free(context, levels->clusters);
    stp_free(context, levels->groups);
    stp_free(context, levels->meshes);
    stp_free(context, levels->coded);
    stp_free(context, levels->keys);
    stp_free(context, levels->materials);
    *levels = (stp_build_levels){0};
}
