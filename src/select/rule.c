// SPDX-License-Identifier: MIT
// What all methods' rules share: which cases there are, and how large splats are wanted.
#include "select/rule.h"

#include "base/prefix_table.h"

const stp_select_rule* stp_select_rule_of(uint32_t id)
{
    switch (id) {
    case STP_METHOD_SPT:
        return &stp_select_rule_levels;
    case STP_METHOD_PSP:
        return &stp_select_rule_splits;
    default:
        return &stp_select_rule_blue;
    }
}

bool stp_select_is_complete(const stp_store_node* node, const stp_splats* surfels)
{
    // points in one place are one surfel: then all of them cover to no farther than positions are exact
    return node->triangle_count == 0 &&
           (surfels->count >= node->point_count ||
            stp_prefix_table_radius(&surfels->table, surfels->count) <= surfels->step);
}

double stp_select_reach(const stp_selection* s, uint32_t node)
{
    return s->graph->reaches[node] *
           fmin((double)s->graph->spares[node], stp_select_spare(s->quality));
}

double stp_select_radius_per_depth(const stp_selection* s, const stp_select_entry* at,
                                   const stp_sight* sight)
{
    double pixel = stp_view_frame_pixel_size(&s->frames[0], 1.0);
    double per_depth = 0.5 * sight->splat_size * pixel; // r = s d_p / 2
    per_depth /= stp_affine_scale(&at->transform);
    return per_depth > 0.0 && isfinite(per_depth) ? per_depth : 0.0;
}

stp_set_use stp_select_use_set(const stp_selection* s, const stp_select_entry* at,
                               const stp_sight* sight)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    const stp_splats* surfels =
        stp_store_describe_surfels(s->store, stp_select_set_of(s, at->node));
    stp_set_use use = {.surfels = surfels, .switch_depth = HUGE_VAL};
    if (surfels->count == 0) {
        return use;
    }
    bool cloud = s->quality->splats_only || stp_select_is_complete(node, surfels);
    if (sight->is_inside && !cloud) {
        return use;
    }
    use.per_depth = stp_select_radius_per_depth(s, at, sight);
    if (!(use.per_depth > 0.0)) {
        if (cloud) {
            s->rule->use_count(&use, surfels->count);
            use.switch_depth = 0.0;
        }
        return use;
    }
    s->rule->use(s, at, sight, cloud, &use);
    return use;
}
