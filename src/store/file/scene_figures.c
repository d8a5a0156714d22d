// SPDX-License-Identifier: MIT
// Sums over the graph. With instances: adds up children before parents. Without: walks with marks.
// Levels do not count: they show what other meshes hold.
#include "base/core/saturate.h"
#include "store/file/content_sizes.h"

#include <assert.h>

// Counts including instances: a node's own plus its children's.
typedef enum instanced {
    INSTANCED_OBJECTS,
    INSTANCED_PARTS,
    INSTANCED_NODES,
    INSTANCED_LODS,
    INSTANCED_TRIANGLES,
    INSTANCED_POINTS,
    INSTANCED_SPLATS,
    INSTANCED_KINDS
} instanced;

typedef struct accumulator {
    stp_context* context;
    const stp_store_sizes* sizes;
    const stp_store_directory* directory;
    uint64_t* sums; ///< by node: count of the current kind, with all instances
    // number of the last walk that visited each item; walks are numbered from 1
    uint32_t *nodes_met, *meshes_met, *point_sets_met, *textures_met, *sets_met;
    uint8_t* material_uses; ///< by material: USED_BY_*
    uint32_t walk;
    uint32_t* stack; ///< visited nodes whose children are still to be visited
    size_t stacked;
} accumulator;

enum { USED_BY_CONTENT = 1, USED_BY_LEVELS = 2 };

static uint64_t* figure_of(stp_store_figures* figures, instanced kind)
{
    switch (kind) {
    case INSTANCED_OBJECTS:
        return &figures->objects;
    case INSTANCED_PARTS:
        return &figures->instances;
    case INSTANCED_NODES:
        return &figures->nodes;
    case INSTANCED_LODS:
        return &figures->lods;
    case INSTANCED_TRIANGLES:
        return &figures->triangles;
    case INSTANCED_POINTS:
        return &figures->points;
    default:
        return &figures->surfels;
    }
}

static uint64_t count_parts(const accumulator* t, const stp_store_node* node,
                            stp_store_part_kind kind)
{
    const stp_store_amount* amounts =
        kind == STP_STORE_PART_MESH ? t->sizes->meshes : t->sizes->point_sets;
    uint64_t sum = 0;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = t->directory->parts[node->first_part + i];
        sum += part.kind == kind ? amounts[part.index].count : 0;
    }
    return sum;
}

// A node's own counts.
static uint64_t count_own(const accumulator* t, const stp_store_node* node, instanced kind)
{
    uint64_t splats = node->set != STP_STORE_NONE ? t->sizes->sets[node->set].count : 0;
    switch (kind) {
    case INSTANCED_OBJECTS:
        return node->part_count != 0;
    case INSTANCED_PARTS:
        return node->part_count;
    case INSTANCED_NODES:
        return 1;
    case INSTANCED_LODS:
        return splats != 0;
    case INSTANCED_TRIANGLES:
        return count_parts(t, node, STP_STORE_PART_MESH);
    case INSTANCED_POINTS:
        return count_parts(t, node, STP_STORE_PART_POINTS);
    default:
        return splats;
    }
}

static uint32_t node_of(const accumulator* t, uint32_t object)
{
    assert(object < t->directory->object_count);
    return t->directory->objects[object].node;
}

static void sum_instances(accumulator* t, instanced kind, const stp_store_census* census,
                          stp_store_summary* summary)
{
    const stp_store_directory* d = t->directory;
    for (uint32_t i = 0; i < d->node_count; ++i) { // children come first
        const stp_store_node* node = &d->nodes[i];
        t->sums[i] = count_own(t, node, kind);
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            assert(d->edges[node->first_edge + k].node < i);
            t->sums[i] =
                stp_add_saturated(t->sums[i], t->sums[d->edges[node->first_edge + k].node]);
        }
    }
    *figure_of(&summary->figures, kind) = d->root != STP_STORE_NONE ? t->sums[d->root] : 0;
    for (uint32_t i = 0; i < census->part_count; ++i) {
        uint64_t* figure = figure_of(&summary->parts[i].figures, kind);
        for (uint32_t k = 0; k < census->parts[i].member_count; ++k) {
            uint32_t node = node_of(t, census->parts[i].members[k]);
            *figure = stp_add_saturated(*figure, node != STP_STORE_NONE ? t->sums[node] : 0);
        }
    }
}

// Whether this walk visits an item for the first time.
static bool is_first_visit(const accumulator* t, uint32_t* met, uint32_t index)
{
    bool first = met[index] != t->walk;
    met[index] = t->walk;
    return first;
}

static void count_node(accumulator* t, uint32_t node)
{
    if (node != STP_STORE_NONE && is_first_visit(t, t->nodes_met, node)) {
        assert(t->stacked < t->directory->node_count && "each node enters once per walk");
        t->stack[t->stacked++] = node;
    }
}

static void count_material(const accumulator* t, uint32_t index, stp_store_figures* figures)
{
    const stp_store_material* material = &t->directory->materials[index];
    const stp_store_texture_use* uses[STP_STORE_MATERIAL_TEXTURES];
    uint32_t count = stp_store_used_textures(material, uses);
    for (uint32_t i = 0; i < count; ++i) {
        const stp_store_amount* texture = &t->sizes->textures[uses[i]->texture];
        if (is_first_visit(t, t->textures_met, texture->owner)) {
            figures->texture_bytes += texture->bytes;
        }
    }
}

static void count_part(const accumulator* t, stp_store_part part, stp_store_figures* figures)
{
    if (part.kind == STP_STORE_PART_MESH && is_first_visit(t, t->meshes_met, part.index)) {
        const stp_store_amount* mesh = &t->sizes->meshes[part.index];
        figures->unique_triangles += mesh->count;
        figures->triangle_bytes += mesh->bytes;
        count_material(t, mesh->material, figures);
    } else if (part.kind == STP_STORE_PART_POINTS &&
               is_first_visit(t, t->point_sets_met, part.index)) {
        const stp_store_amount* points = &t->sizes->point_sets[part.index];
        figures->unique_points += points->count;
        figures->point_bytes += points->bytes;
        count_material(t, points->material, figures);
    }
}

// Visits everything below the nodes on the stack once.
static void walk(accumulator* t, stp_store_figures* figures)
{
    const stp_store_directory* d = t->directory;
    while (t->stacked != 0) {
        const stp_store_node* node = &d->nodes[t->stack[--t->stacked]];
        figures->unique_nodes += 1;
        figures->unique_objects += node->part_count != 0;
        for (uint32_t i = 0; i < node->part_count; ++i) {
            count_part(t, d->parts[node->first_part + i], figures);
        }
        const stp_store_amount* sets = t->sizes->sets;
        if (node->set != STP_STORE_NONE && sets[node->set].count != 0 &&
            is_first_visit(t, t->sets_met, node->set)) {
            figures->unique_lods += 1;
            figures->unique_surfels += sets[node->set].count;
            figures->splat_bytes += sets[node->set].bytes;
        }
        // other methods only count for bytes; readers that do not know coarse ellipses, which come
        // last, find the same figures
        for (uint32_t m = 1; m < stp_store_offered_methods(d); ++m) {
            uint32_t set = stp_store_set_of(d, m, (uint32_t)(node - d->nodes));
            bool new_one = set != STP_STORE_NONE && is_first_visit(t, t->sets_met, set);
            figures->splat_bytes += new_one ? sets[set].bytes : 0;
        }
        for (uint32_t i = 0; i < node->edge_count; ++i) {
            count_node(t, d->edges[node->first_edge + i].node);
        }
    }
}

static void sum_unique(accumulator* t, const stp_store_census* census, stp_store_summary* summary)
{
    t->walk = 1;
    assert(t->stacked == 0);
    count_node(t, t->directory->root);
    walk(t, &summary->figures);
    for (uint32_t i = 0; i < census->part_count; ++i) {
        t->walk += 1;
        for (uint32_t k = 0; k < census->parts[i].member_count; ++k) {
            count_node(t, node_of(t, census->parts[i].members[k]));
        }
        walk(t, &summary->parts[i].figures);
    }
}

// Totals of the whole scene count all stored content, drawn or not. Nodes are the exception: an
// object whose content was moved to its parent keeps a node that is never drawn.
static void sum_stored(const accumulator* t, stp_store_figures* figures)
{
    const stp_store_directory* d = t->directory;
    const stp_store_sizes* m = t->sizes;
    figures->unique_triangles = figures->triangle_bytes = 0;
    figures->unique_points = figures->point_bytes = 0;
    figures->unique_lods = figures->unique_surfels = figures->splat_bytes = 0;
    figures->texture_bytes = 0;
    for (uint32_t i = 0; i < stp_store_first_level_mesh(d); ++i) {
        figures->unique_triangles += m->meshes[i].count;
        figures->triangle_bytes += m->meshes[i].bytes;
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        figures->unique_points += m->point_sets[i].count;
        figures->point_bytes += m->point_sets[i].bytes;
    }
    for (uint32_t i = 0; i < d->texture_count; ++i) {
        figures->texture_bytes += m->textures[i].owner == i ? m->textures[i].bytes : 0;
    }
    for (uint32_t i = 0; i < d->set_count; ++i) {
        figures->unique_lods += m->sets[i].count != 0;
        figures->unique_surfels += m->sets[i].count;
        figures->splat_bytes += m->sets[i].bytes;
    }
}

static void take_census(const stp_store_census* census, stp_store_summary* summary)
{
    summary->figures.objects = census->objects;
    summary->figures.unique_objects = census->unique_objects;
    summary->figures.instances = census->instances;
    for (uint32_t i = 0; i < census->part_count; ++i) {
        stp_store_figures* figures = &summary->parts[i].figures;
        figures->objects = census->parts[i].objects;
        figures->unique_objects = census->parts[i].unique_objects;
        figures->instances = census->parts[i].instances;
    }
}

static bool create_accumulator(accumulator* t)
{
    const stp_store_directory* d = t->directory;
    stp_context* context = t->context;
    t->sums = STP_NEW_ZEROED(context, uint64_t, (size_t)d->node_count + 1);
    t->stack = STP_NEW_ARRAY(context, uint32_t, (size_t)d->node_count + 1);
    t->nodes_met = STP_NEW_ZEROED(context, uint32_t, (size_t)d->node_count + 1);
    t->meshes_met = STP_NEW_ZEROED(context, uint32_t, (size_t)d->mesh_count + 1);
    t->point_sets_met = STP_NEW_ZEROED(context, uint32_t, (size_t)d->point_set_count + 1);
    t->textures_met = STP_NEW_ZEROED(context, uint32_t, (size_t)d->texture_count + 1);
    t->sets_met = STP_NEW_ZEROED(context, uint32_t, (size_t)d->set_count + 1);
    t->material_uses = STP_NEW_ZEROED(context, uint8_t, (size_t)d->material_count + 1);
    return t->sums != NULL && t->stack != NULL && t->nodes_met != NULL && t->meshes_met != NULL &&
           t->point_sets_met != NULL && t->textures_met != NULL && t->sets_met != NULL &&
           t->material_uses != NULL;
}

static void destroy_accumulator(accumulator* t)
{
    void* arrays[] = {t->sums,           t->stack,        t->nodes_met, t->meshes_met,
                      t->point_sets_met, t->textures_met, t->sets_met,  t->material_uses};
    for (size_t i = 0; i < sizeof(arrays) / sizeof(arrays[0]); ++i) {
        stp_free(t->context, arrays[i]);
    }
}

// All materials, without those at the end of the table that only levels use: the builder makes
// such materials for them.
static uint32_t count_materials(accumulator* t)
{
    const stp_store_directory* d = t->directory;
    for (uint32_t i = 0; i < d->mesh_count; ++i) {
        bool level = i >= stp_store_first_level_mesh(d);
        t->material_uses[t->sizes->meshes[i].material] |= level ? USED_BY_LEVELS : USED_BY_CONTENT;
    }
    for (uint32_t i = 0; i < d->point_set_count; ++i) {
        t->material_uses[t->sizes->point_sets[i].material] |= USED_BY_CONTENT;
    }
    uint32_t count = d->material_count;
    while (count > 0 && t->material_uses[count - 1] == USED_BY_LEVELS) {
        count -= 1;
    }
    return count;
}

static void start_summary(accumulator* t, const stp_store_census* census,
                          stp_store_summary* summary)
{
    const stp_store_directory* d = t->directory;
    summary->bounds = d->root != STP_STORE_NONE ? d->nodes[d->root].bounds : stp_boxd_empty();
    summary->material_count = count_materials(t);
    summary->texture_count = d->texture_count;
    summary->mesh_count = stp_store_first_level_mesh(d);
    summary->point_set_count = d->point_set_count;
    summary->part_count = census->part_count;
    for (uint32_t i = 0; i < census->part_count; ++i) {
        const stp_store_census_part* part = &census->parts[i];
        summary->parts[i].name = part->name;
        summary->parts[i].object = part->member_count == 1 ? part->members[0] : STP_STORE_NONE;
    }
}

stp_result stp_store_count_figures(stp_context* context, const stp_store_sizes* sizes,
                                   const stp_store_census* census, bool counted,
                                   stp_store_summary* summary)
{
    assert(census->part_count <= STP_STORE_SCENE_PARTS + 1);
    accumulator t = {.context = context, .sizes = sizes, .directory = sizes->directory};
    *summary = (stp_store_summary){0};
    summary->parts = STP_NEW_ZEROED(context, stp_store_scene_part, (size_t)census->part_count + 1);
    bool made = summary->parts != NULL && create_accumulator(&t);
    if (made) {
        start_summary(&t, census, summary);
        for (int kind = 0; kind < INSTANCED_KINDS; ++kind) {
            sum_instances(&t, (instanced)kind, census, summary);
        }
        sum_unique(&t, census, summary);
        sum_stored(&t, &summary->figures);
        if (counted) {
            take_census(census, summary);
        }
    } else {
        stp_store_summary_destroy(context, summary);
    }
    destroy_accumulator(&t);
    return made ? STP_OK : stp_fail_memory(context);
}
