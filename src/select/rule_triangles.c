// SPDX-License-Identifier: MIT
// Large triangles beside splats (Dachsbacher et al. 2003, 3.8). A build looks for them below a node
// as far as STP_LARGE_USES parts and nodes, so that a view need not look at more.
#include "select/rule.h"

#include <assert.h>

// Half of a view's limit: content that splats can represent must not make a view fail.
#define IDS_MAX (UINT64_C(1) << 31)
#define ITEMS_MAX (UINT64_C(1) << 18)
/// clusters are slightly smaller or larger than the triangles that the build used
#define ROUNDED 0.95

/// State of the traversal below a node.
typedef struct walk {
    stp_selection* s;
    const stp_select_entry* at;
    const stp_set_use* use;
    const stp_box_visibility* sight;
    enum { WALK_COUNTS, WALK_ASKS, WALK_ADDS } does;
    uint32_t left;  ///< parts and nodes that may still be visited
    uint32_t items; ///< items to add
    uint64_t ids;   ///< triangles of these items: their ids
    bool all;       ///< requested data is resident
} walk;

/// Whether large triangles replace any loaded splat of the prefix.
static stp_result has_replaced(const stp_selection* s, const stp_set_use* use, bool* has)
{
    *has = false;
    if ((use->splats->columns & STP_SPLATS_REPLACED) == 0) {
        return STP_OK;
    }
    uint32_t octaves = stp_store_octaves_for(use->splats, use->count);
    stp_splats here;
    stp_result result = stp_store_get_splat_set_prefix(s->store, use->set, octaves, &here);
    if (result != STP_OK || here.groups == NULL) {
        return result;
    }
    uint32_t count = use->count < here.count ? use->count : here.count;
    for (uint32_t i = 0; i < count && !*has; i += STP_GROUP_SPLATS) {
        *has = here.groups[i / STP_GROUP_SPLATS].replaced != 0;
    }
    return STP_OK;
}

/// Whether a part can have large triangles at this scale.
static bool has_large(const walk* w, stp_store_part part, double scale)
{
    const stp_selection* s = w->s;
    if (part.kind != STP_STORE_PART_MESH || !stp_store_is_clustered(s->store, part.index)) {
        return false;
    }
    const stp_store_mesh* mesh = stp_store_describe_mesh(s->store, part.index);
    stp_vec3 size = stp_sub(mesh->bounds.max, mesh->bounds.min);
    double level = 0.5 * (double)stp_length(size) * scale;
    return level > ROUNDED * s->graph->reaches[w->at->node] &&
           s->directory->materials[mesh->material].alpha == STP_STORE_OPAQUE;
}

/// @param below from mesh space to the space of the set's node
static stp_result add_item(const walk* w, uint32_t mesh, const stp_affine* below, double scale)
{
    stp_selection* s = w->s;
    const stp_set_use* use = w->use;
    assert(scale > 0.0 && "a flattened mesh has no large triangles");
    double from = fmax(use->level_per_depth * w->sight->range.near, use->level_min);
    stp_draw_item item = {.kind = STP_DRAW_MESH,
                          .index = mesh,
                          .large = true,
                          .large_min = (float)(s->graph->reaches[w->at->node] / scale),
                          .large_from = (float)(from / scale),
                          .level_per_depth = (float)(use->level_per_depth / scale),
                          .level_min = (float)(use->level_min / scale),
                          .switch_begin = (float)(use->switch_depth * (1.0 - 1e-6)),
                          .transform = stp_affine_multiply(w->at->transform, *below)};
    return stp_select_add_item(s, item, stp_store_describe_mesh(s->store, mesh)->triangle_count);
}

static stp_result add_node(walk* w, uint32_t index, const stp_affine* below)
{
    stp_selection* s = w->s;
    const stp_store_node* node = &s->directory->nodes[index];
    double scale = stp_affine_scale(below);
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < node->part_count && w->left > 0 && result == STP_OK; ++i) {
        uint32_t k = node->first_part + i;
        stp_store_part part = s->directory->parts[k];
        bool repeated = (s->graph->repeated[k / 8] >> k % 8 & 1) != 0;
        w->left -= 1;
        if (repeated || !(scale > 0.0) || !has_large(w, part, scale)) {
            continue;
        }
        w->items += 1;
        w->ids += stp_store_describe_mesh(s->store, part.index)->triangle_count;
        if (w->does == WALK_ADDS) {
            result = add_item(w, part.index, below, scale);
        } else if (w->does == WALK_ASKS) {
            w->all = stp_select_request_optional_mesh(s, part.index) && w->all;
        }
    }
    for (uint32_t i = 0; i < node->edge_count && w->left > 0 && result == STP_OK; ++i) {
        const stp_store_edge* edge = &s->directory->edges[node->first_edge + i];
        assert(edge->node < index && "children come before their parents: the recursion ends");
        stp_affine transform = stp_affine_multiply(*below, edge->transform);
        w->left -= 1;
        if ((s->graph->moving[edge->node] & STP_NODE_MOVES) == 0) {
            result = add_node(w, edge->node, &transform);
        }
    }
    return result;
}

static walk begin_walk(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                       const stp_box_visibility* sight)
{
    return (walk){
        .s = s, .at = at, .use = use, .sight = sight, .left = STP_LARGE_USES + 1, .all = true};
}

stp_result stp_select_choose_triangles(stp_selection* s, const stp_select_entry* at,
                                       const stp_set_use* use, const stp_box_visibility* sight,
                                       bool* uses)
{
    const stp_quality* q = s->quality;
    bool by_level = use->level_per_depth > 0.0 || use->level_min > 0.0;
    *uses = false;
    if (q->splats_only || q->nodes_only || q->splat_count != 0 || !by_level || at->sections != 0 ||
        at->shown == STP_SHOW_GHOST) {
        return STP_OK;
    }
    bool replaced = false;
    stp_result result = has_replaced(s, use, &replaced);
    stp_affine here = stp_affine_identity();
    walk w = begin_walk(s, at, use, sight);
    if (result == STP_OK && replaced) {
        result = add_node(&w, at->node, &here);
    }
    bool fits = s->list->id_count + w.ids + use->splats->count < IDS_MAX &&
                s->list->count + w.items < ITEMS_MAX;
    if (result != STP_OK || w.left == 0 || w.items == 0 || !fits) {
        return result;
    }
    w = begin_walk(s, at, use, sight);
    w.does = WALK_ASKS;
    result = s->streams ? add_node(&w, at->node, &here) : STP_OK;
    *uses = w.all;
    return result;
}

stp_result stp_select_add_triangles(stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use, const stp_box_visibility* sight)
{
    assert(s->list->count > 0 && s->list->items[s->list->count - 1].kind == STP_DRAW_SPLATS &&
           s->list->items[s->list->count - 1].index == use->set && "the set's item is the last");
    walk w = begin_walk(s, at, use, sight);
    w.does = WALK_ADDS;
    stp_affine here = stp_affine_identity();
    return add_node(&w, at->node, &here);
}
