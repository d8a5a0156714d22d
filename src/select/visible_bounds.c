// SPDX-License-Identifier: MIT
#include "base/core/context.h"
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

static double overhang(const stp_boxd* inner, const stp_boxd* outer)
{
    double low = fmax(fmax(outer->min.x - inner->min.x, outer->min.y - inner->min.y),
                      outer->min.z - inner->min.z);
    double high = fmax(fmax(inner->max.x - outer->max.x, inner->max.y - outer->max.y),
                       inner->max.z - outer->max.z);
    return fmax(fmax(low, high), 0.0);
}

/// How far the content of a node may lie outside its bounds. `below`: the same for its children, of
/// lower indices.
static double node_rounding(const stp_store* store, uint32_t node, const double* below)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    const stp_store_node* n = &d->nodes[node];
    const stp_affine identity = stp_affine_identity();
    double most = 0.0;
    for (uint32_t i = 0; i < n->part_count; ++i) {
        stp_instance part = stp_instance_of_part(store, d->parts[n->first_part + i], &identity);
        most = fmax(most, overhang(&part.bounds, &n->bounds));
    }
    for (uint32_t i = 0; i < n->edge_count; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        most = fmax(most, stp_affine_scale(&edge->transform) * below[edge->node]);
    }
    for (uint32_t i = 0; i < d->method_count; ++i) {
        uint32_t set = stp_store_set_of(d, i, node);
        double step =
            set != STP_STORE_NONE ? (double)stp_store_describe_splat_set(store, set)->step : 0.0;
        most = fmax(most, step);
    }
    uint32_t levels = d->level_starts != NULL ? d->level_starts[node + 1] : 0;
    for (uint32_t i = levels > 0 ? d->level_starts[node] : 0; i < levels; ++i) {
        stp_box box = stp_store_describe_mesh(store, stp_store_first_level_mesh(d) + i)->bounds;
        stp_boxd wide = {stp_to_double(box.min), stp_to_double(box.max)};
        most = fmax(most, overhang(&wide, &n->bounds));
    }
    return most;
}

double stp_bounds_rounding(stp_context* context, const stp_store* store)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    double* below = STP_NEW_ARRAY(context, double, d->node_count);
    if (below == NULL || d->root == STP_STORE_NONE) {
        stp_free(context, below);
        return 0.0;
    }
    for (uint32_t i = 0; i < d->node_count; ++i) {
        below[i] = node_rounding(store, i, below);
    }
    double rounding = below[d->root];
    stp_free(context, below);
    return rounding;
}
