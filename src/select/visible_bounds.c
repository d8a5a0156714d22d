// SPDX-License-Identifier: MIT
#include "select/visibility.h"
#include "store/file/instances.h"

static void add_box(stp_boxd* to, const stp_boxd* box)
{
    if (!stp_boxd_is_empty(*box)) {
        stp_boxd_add(to, box->min);
        stp_boxd_add(to, box->max);
    }
}

/// Adds the bounds of the drawn content of a node at a place. Only mixed nodes are opened; they
/// form a tree no deeper than STP_INSTANCE_DEPTH.
static void add_node(const stp_store* store, const stp_visibility* v, uint32_t node,
                     const stp_affine* transform, uint32_t state, stp_boxd* bounds)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_node* n = &d->nodes[node];
    if (stp_show_of(state) != STP_SHOW_MIXED) {
        stp_boxd box = stp_affine_box(transform, n->bounds);
        if (stp_show_of(state) != STP_SHOW_NOT) {
            add_box(bounds, &box);
        }
        return;
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        add_node(store, v, edge->node, &below, stp_visibility_below(v, state, i), bounds);
    }
    for (uint32_t i = 0; i < n->part_count; ++i) {
        if (stp_visibility_below(v, state, n->edge_count + i) != STP_SHOW_NOT) {
            stp_instance spot = stp_instance_of_part(store, d->parts[n->first_part + i], transform);
            stp_boxd box = stp_affine_box(transform, spot.bounds);
            add_box(bounds, &box);
        }
    }
}

stp_boxd stp_visible_bounds(const stp_store* store, const stp_visibility* visibility)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    stp_boxd bounds = stp_boxd_empty();
    if (d->root == STP_STORE_NONE) {
        return bounds;
    }
    if (visibility == NULL) {
        return d->nodes[d->root].bounds;
    }
    stp_affine identity = stp_affine_identity();
    add_node(store, visibility, d->root, &identity, stp_visibility_root(visibility), &bounds);
    return bounds;
}
