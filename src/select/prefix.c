// SPDX-License-Identifier: MIT
// How many surfels of a node are drawn, and from what depth on they suffice.
#include "base/prefix_table.h"
#include "select/select_internal.h"

bool stp_select_is_complete(const stp_store_node* node, const stp_surfels* surfels)
{
    // points in one place are one surfel: then all of them cover to no farther than positions are exact
    return node->triangle_count == 0 &&
           (surfels->count >= node->point_count ||
            stp_prefix_table_radius(&surfels->table, surfels->count) <= surfels->step);
}

// Candidates only sample the surface, so no point of it is farther from a splat than what the prefix covers to and the
// candidates' radius together. Hardly any is as far: of large splats all of it would only show beyond edges, where nothing is.
#define ROOMY 2.0 ///< pixels up to which all of the candidates' radius is added
#define CLOSE 4.0 ///< and from which on half of it is

/// The prefix, and how large its disks are where splats of so many pixels are wanted.
static void use_count(stp_set_use* use, uint32_t count, double splat_size)
{
    double roomy = (CLOSE - splat_size) / (CLOSE - ROOMY);
    double share = 0.5 + 0.5 * (roomy > 0.0 ? fmin(roomy, 1.0) : 0.0);
    use->count = count;
    use->radius = (double)stp_prefix_table_radius(&use->surfels->table, count) +
                  share * (double)use->surfels->candidate_radius;
}

/// p(r) = p_m (r_m / r)^2, Brandt 4.1.
static void use_estimate(stp_set_use* use, double radius, bool cloud)
{
    const stp_surfels* surfels = use->surfels;
    double ratio = (double)surfels->paper_radius / radius;
    double wanted = ceil((double)surfels->paper_count * ratio * ratio);
    if (!(wanted <= (double)surfels->count) && !cloud) {
        return;
    }
    use->count = wanted < 1.0                      ? 1
                 : wanted < (double)surfels->count ? (uint32_t)wanted
                                                   : surfels->count;
    use->radius = radius;
    use->switch_depth = 0.0;
}

#define SHORT 2.0 ///< far over near depth up to which a node is opened slowly
#define LONG 3.0  ///< and from which on it is opened soon

/// By what the depth from which a node suffices is multiplied where its nearest part lacks some of the radius: by the third
/// power of that, and by up to the seventh for a long node. All of it is opened before the eye is within its box,
/// and before few of its surfels are drawn of many that are looked at; what is short is seen at about one depth
/// and has the time to go by degrees.
static double move_out(double lacks, stp_depth_range range)
{
    double length = (range.far / range.near - SHORT) / (LONG - SHORT);
    double part = length > 0.0 ? fmin(length, 1.0) : 0.0;
    double cubed = lacks * lacks * lacks;
    return cubed * (1.0 + part * (cubed * lacks - 1.0));
}

/// The coverage radius down to which a node's own surfels are used.
static double reach_of(const stp_selection* s, uint32_t node)
{
    return s->graph->reaches[node] *
           fmin((double)s->graph->spares[node], stp_select_spare(s->quality));
}

/// The prefix of a set that is to be opened, with its radius, such that it and what grows in are no more work than
/// STP_TRANSITION_WORK times the dearer of the two. A shorter prefix still covers, with larger splats.
static void use_beside(stp_set_use* use, uint32_t count, double size, double below, double grown)
{
    double own = STP_SPLAT_WORK * (double)count;
    double most = STP_TRANSITION_WORK * fmax(own, below) - grown * below;
    if (most < own) {
        double part = (double)count * (most / own);
        count = part > 1.0 ? (uint32_t)part : 1;
    }
    use_count(use, count, size);
}

/// By insertion radius: as many as cover at the nearest depth, or all where they do not; opened where a finer
/// radius is wanted than its surfels are used for.
static void use_by_insertion(stp_set_use* use, const stp_selection* s, const stp_sight* sight,
                             const stp_select_entry* at, bool cloud)
{
    const stp_surfels* surfels = use->surfels;
    stp_depth_range range = sight->range;
    double size = cloud ? 0.0 : sight->splat_size; // clouds are drawn however near, with gaps
    double suffices_from = reach_of(s, at->node) / use->per_depth;
    double below = (double)s->graph->works[at->node];
    uint32_t count = stp_prefix_table_count(&surfels->table, (float)(use->per_depth * range.near));
    bool suffices = cloud || range.near >= suffices_from;
    if (!suffices && s->quality->policy == STP_POLICY_SWITCH) {
        return;
    }
    if (cloud || (suffices && s->quality->policy == STP_POLICY_SWITCH)) {
        use_count(use, count, size);
        use->switch_depth = 0.0;
        return;
    }
    if (suffices) {
        use->switch_depth = suffices_from;
        use_beside(use, count, size, below, stp_select_growth(suffices_from, range.near));
        return;
    }
    use->switch_depth = suffices_from * move_out(suffices_from / range.near, range);
    use->extra = true;
    if (range.far * STP_LEVELS_SHRINK > use->switch_depth) {
        use_beside(use, count, size, below, 1.0);
    }
}

stp_set_use stp_select_use_set(const stp_selection* s, const stp_select_entry* at,
                               const stp_sight* sight)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    const stp_surfels* surfels = stp_store_describe_surfels(s->store, node->surfels);
    stp_set_use use = {.surfels = surfels, .switch_depth = HUGE_VAL};
    if (surfels->count == 0) {
        return use;
    }
    bool cloud = stp_select_is_complete(node, surfels);
    uint64_t wanted = s->quality->splat_count, made = s->list->splat_count;
    if (wanted > 0) {
        // what moves has a set of its own: together they are as many as was asked for
        uint64_t left = wanted > made ? wanted - made : 0;
        if (left > 0) {
            use_count(&use, left < surfels->count ? (uint32_t)left : surfels->count, 0.0);
            use.switch_depth = 0.0;
        }
        return use;
    }
    double pixel = stp_view_frame_pixel_size(&s->frames[0], 1.0);
    double per_depth = 0.5 * sight->splat_size * pixel; // r = s d_p / 2
    per_depth /= stp_affine_scale(&at->transform);
    if (sight->is_inside && !cloud) {
        return use;
    }
    if (!(per_depth > 0.0) || !isfinite(per_depth)) {
        if (cloud) {
            use_count(&use, surfels->count, 0.0);
            use.switch_depth = 0.0;
        }
        return use;
    }
    if (s->quality->policy == STP_POLICY_PAPER) {
        use_estimate(&use, per_depth * sight->range.near, cloud);
    } else {
        use.per_depth = per_depth;
        use_by_insertion(&use, s, sight, at, cloud);
    }
    return use;
}
