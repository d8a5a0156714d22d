// SPDX-License-Identifier: MIT
// Large triangles beside splats (Dachsbacher et al. 2003, 3.8). A build looks for them below a node as far as
// STP_LARGE_USES parts and nodes, so that a view need not look at more.
#include "select/rule.h"

#define ROUNDED                                                                                    \
    0.95 ///< clusters are a little smaller or larger than the triangles that a build saw

/// What the walk below a node takes along.
typedef struct walk {
    stp_selection* s;
    const stp_select_entry* at;
    const stp_set_use* use;
    const stp_sight* sight;
    uint32_t left; ///< parts and nodes that may still be looked at
    bool adds;     ///< else it asks whether meshes are here
    bool all;      ///< they are
} walk;

/// Whether large triangles may replace splats of the prefix: for certain where the set is loaded.
static bool has_replaced(const stp_selection* s, const stp_splats* surfels, uint32_t count)
{
    if ((surfels->columns & STP_SPLATS_REPLACED) == 0) {
        return false;
    }
    if (surfels->groups == NULL) {
        return !s->streams;
    }
    for (uint32_t i = 0; i < count; i += STP_GROUP_SPLATS) {
        if (surfels->groups[i / STP_GROUP_SPLATS].replaced != 0) {
            return true;
        }
    }
    return false;
}

/// Whether a part can have triangles that count at this scale.
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

/// @param below from the space of the mesh to that of the set's node
static stp_result add_item(const walk* w, uint32_t mesh, const stp_affine* below, double scale)
{
    stp_selection* s = w->s;
    const stp_set_use* use = w->use;
    double from = fmax(use->level_per_depth * w->sight->range.near, use->level_least);
    stp_draw_item item = {.kind = STP_DRAW_MESH,
                          .index = mesh,
                          .large = true,
                          .large_least = (float)(s->graph->reaches[w->at->node] / scale),
                          .large_from = (float)(from / scale),
                          .level_per_depth = (float)(use->level_per_depth / scale),
                          .level_least = (float)(use->level_least / scale),
                          .fade_begin = (float)(use->switch_depth * (1.0 - 1e-6)),
                          .transform = stp_affine_multiply(w->at->transform, *below)};
    return stp_select_add_item(s, item, stp_store_describe_mesh(s->store, mesh)->triangle_count);
}

static stp_result look_at(walk* w, uint32_t index, const stp_affine* below)
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
        if (w->adds) {
            result = add_item(w, part.index, below, scale);
        } else if (s->streams) {
            w->all = stp_select_want_part(s, part, w->at, w->sight) && w->all;
        }
    }
    for (uint32_t i = 0; i < node->edge_count && w->left > 0 && result == STP_OK; ++i) {
        const stp_store_edge* edge = &s->directory->edges[node->first_edge + i];
        stp_affine transform = stp_affine_multiply(*below, edge->transform);
        w->left -= 1;
        if ((s->graph->moving[edge->node] & STP_NODE_MOVES) == 0) {
            result = look_at(w, edge->node, &transform);
        }
    }
    return result;
}

bool stp_select_uses_triangles(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                               const stp_sight* sight)
{
    const stp_quality* q = s->quality;
    bool by_level = use->level_per_depth > 0.0 || use->level_least > 0.0;
    if (q->splats_only || q->nodes_only || q->splat_count != 0 || !by_level || at->sections != 0 ||
        at->shown == STP_SHOW_GHOST || !has_replaced(s, use->surfels, use->count)) {
        return false;
    }
    walk w = {
        .s = s, .at = at, .use = use, .sight = sight, .left = STP_LARGE_USES + 1, .all = true};
    stp_affine here = stp_affine_identity();
    return look_at(&w, at->node, &here) == STP_OK && w.all && w.left > 0;
}

stp_result stp_select_add_triangles(stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use, const stp_sight* sight)
{
    walk w = {
        .s = s, .at = at, .use = use, .sight = sight, .left = STP_LARGE_USES + 1, .adds = true};
    stp_affine here = stp_affine_identity();
    return look_at(&w, at->node, &here);
}
