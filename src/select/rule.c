// SPDX-License-Identifier: MIT
// Shared by the rules of all methods: the cases, and the wanted splat size.
#include "select/rule.h"

#include "base/splats/prefix_table.h"

#include <assert.h>

const stp_select_rule* stp_select_rule_of(uint32_t id)
{
    switch (id) {
    case STP_METHOD_SPT:
        return &stp_select_rule_levels;
    case STP_METHOD_PSP:
    case STP_METHOD_COARSE:
        return &stp_select_rule_splits;
    case STP_METHOD_STOCHASTIC:
        return &stp_select_rule_cues;
    default:
        return &stp_select_rule_blue;
    }
}

/// Whether a set holds all points of a node without triangles: such a node is never opened, since
/// points have no size of their own. A set with fewer splats is complete, too, if all other points
/// coincide with them.
static bool is_complete(const stp_store_node* node, const stp_splats* splats)
{
    // coincident points share one splat, so all splats together cover to within position
    // precision
    return node->triangle_count == 0 &&
           (splats->count >= node->point_count ||
            stp_prefix_table_radius(&splats->table, splats->count) <= splats->step);
}

double stp_select_reach(const stp_selection* s, uint32_t node, double splat_size)
{
    double own = s->graph->reaches[node] *
                 fmin((double)s->graph->early_switches[node], stp_select_early_switch(s->quality));
    if (!s->draws_levels) {
        return own;
    }
    const float* opens = s->graph->opens_below + 2 * (size_t)node;
    double part = log(splat_size / STP_OPENS_FINE) / log(STP_OPENS_COARSE / STP_OPENS_FINE);
    part = stp_clampd(part, 0.0, 1.0);
    return fmax(own, (1.0 - part) * (double)opens[0] + part * (double)opens[1]);
}

/// The wanted coverage radius at depth 1, in node units; 0: none.
static double radius_per_depth(const stp_selection* s, const stp_select_entry* at,
                               const stp_box_visibility* sight)
{
    double pixel = stp_view_frame_pixel_size(&s->frames[0], 1.0);
    double per_depth = 0.5 * sight->splat_size * pixel; // r = s d_p / 2
    per_depth /= stp_affine_scale(&at->transform);
    return per_depth > 0.0 && isfinite(per_depth) ? per_depth : 0.0;
}

bool stp_select_find_nearest(const stp_selection* s, const stp_select_entry* at,
                             const stp_box_visibility* sight, bool cloud, stp_set_use* use,
                             double* nearest)
{
    assert(use->per_depth > 0.0 && "drawn by size");
    double suffices_from = stp_select_reach(s, at->node, sight->splat_size) / use->per_depth;
    stp_depth_range range = sight->range;
    bool suffices = cloud || range.near >= suffices_from;
    bool part = !suffices && range.far > suffices_from && s->quality->policy != STP_POLICY_SWITCH;
    *nearest = suffices ? range.near : suffices_from;
    use->switch_depth = suffices ? 0.0 : suffices_from;
    use->in_level_switch = part;
    return suffices || part;
}

stp_set_use stp_select_begin_use(const stp_selection* s, const stp_select_rule* rule, uint32_t set)
{
    assert(set < s->directory->set_count && "the node has a set");
    return (stp_set_use){.rule = rule,
                         .set = set,
                         .splats = stp_store_describe_splat_set(s->store, set),
                         .switch_depth = HUGE_VAL};
}

// Of a node's own set. Measured on the benchmark scene (docs/notes/2026-11-coarse-ellipses.md).
#define COARSE_SHARE 0.25

uint32_t stp_select_coarse_method(const stp_store_directory* directory, const stp_quality* quality)
{
    uint32_t found = STP_STORE_NONE;
    if (quality->method != 0 || quality->reference || quality->policy != STP_POLICY_INSERTION ||
        directory->method_count < 2 || directory->methods[0].id != STP_METHOD_BLUE) {
        return found;
    }
    for (uint32_t i = 1; i < directory->method_count; ++i) {
        uint32_t id = directory->methods[i].id;
        found = id == STP_METHOD_PSP || id == STP_METHOD_COARSE ? i : found;
    }
    return found;
}

bool stp_select_draws_levels(const stp_selection* s)
{
    const stp_quality* q = s->quality;
    return s->directory->level_count > 0 && q->method == 0 && !q->reference && !q->splats_only &&
           !q->nodes_only && q->splat_count == 0 && q->policy == STP_POLICY_INSERTION &&
           (s->directory->method_count == 0 ||
            s->directory->methods[s->method].id == STP_METHOD_BLUE);
}

/// Begins to use the coarse set of a node for `count` splats of its own set. @return whether that
/// is a small enough share of it
static bool begin_coarse(const stp_selection* s, uint32_t node, const stp_splats* own,
                         uint32_t count, stp_set_use* use)
{
    uint32_t set = s->coarse_method != STP_STORE_NONE
                       ? stp_store_set_of(s->directory, s->coarse_method, node)
                       : STP_STORE_NONE;
    if (set == STP_STORE_NONE || count == 0 || (double)count >= COARSE_SHARE * (double)own->count) {
        return false;
    }
    const stp_select_rule* rule = stp_select_rule_of(s->directory->methods[s->coarse_method].id);
    *use = stp_select_begin_use(s, rule, set);
    return use->splats->count > 0;
}

void stp_select_choose_coarse(stp_selection* s, const stp_select_entry* at,
                              const stp_box_visibility* sight, stp_set_use* use)
{
    stp_set_use other;
    if (use->in_level_switch || !(use->per_depth > 0.0) ||
        !begin_coarse(s, at->node, use->splats, use->count, &other)) {
        return;
    }
    other.per_depth = use->per_depth;
    other.rule->choose(s, at, sight, false, &other);
    assert(other.count <= other.splats->count);
    const stp_splats* splats = other.splats;
    bool suffices = other.radius >= (double)stp_prefix_table_radius(&splats->table, splats->count);
    if (other.count > 0 && suffices &&
        (!s->streams || stp_select_request_coarse(s, at, sight, &other))) {
        *use = other;
    }
}

stp_result stp_select_count_coarse(stp_selection* s, const stp_select_entry* at,
                                   const stp_box_visibility* sight, uint32_t count,
                                   stp_set_use* use)
{
    stp_set_use other;
    if (!begin_coarse(s, at->node, use->splats, count, &other) ||
        count > (other.splats->count + 1) / 2) {
        return STP_OK;
    }
    other.switch_depth = use->switch_depth;
    other.rule->choose_count(&other, count);
    if (s->streams && !stp_select_request_coarse(s, at, sight, &other)) {
        return STP_OK;
    }
    uint32_t states = 0;
    bool ends = false;
    stp_result result = stp_select_count_states(s->store, other.set, &states, &ends);
    if (result == STP_OK && ends && count >= 2 * states - other.splats->count) {
        *use = other;
    }
    return result;
}

stp_set_use stp_select_choose_use(const stp_selection* s, const stp_select_entry* at,
                                  const stp_box_visibility* sight)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    stp_set_use use = stp_select_begin_use(s, s->rule, stp_select_set_of(s, at->node));
    const stp_splats* splats = use.splats;
    if (splats->count == 0) {
        return use;
    }
    bool cloud = s->quality->splats_only || is_complete(node, splats);
    if (sight->is_inside && !cloud) {
        return use;
    }
    use.per_depth = radius_per_depth(s, at, sight);
    if (!(use.per_depth > 0.0)) {
        if (cloud) {
            s->rule->choose_count(&use, splats->count);
            use.switch_depth = 0.0;
        }
        return use;
    }
    s->rule->choose(s, at, sight, cloud, &use);
    assert(use.count <= splats->count);
    return use;
}

stp_draw_item stp_select_splat_item(const stp_selection* s, const stp_select_entry* at,
                                    const stp_set_use* use)
{
    assert(use->count <= use->splats->count && "a prefix of the set");
    return (stp_draw_item){.kind = STP_DRAW_SPLATS,
                           .index = use->set,
                           .prefix = use->count,
                           .full_prefix = use->count,
                           .radius = (float)use->radius,
                           .sections = at->sections,
                           .ghost = at->shown == STP_SHOW_GHOST,
                           .one_sided = !s->quality->all_sides &&
                                        s->directory->nodes[at->node].point_count == 0 &&
                                        !use->splats->unknown_signs,
                           .transform = at->transform};
}

bool stp_select_is_of_points(const stp_selection* s, uint32_t node)
{
    const stp_store_node* n = &s->directory->nodes[node];
    return n->triangle_count == 0 && n->point_count > 0;
}
