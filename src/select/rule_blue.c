// SPDX-License-Identifier: MIT
// Method `blue`: the number of surfels drawn of a node, the depth beyond which they suffice, and
// the level switch. Each splat of a set is drawn between two depths. Beyond the far depth fewer
// splats, or those of an ancestor, suffice; nearer than the near depth the node is opened.
#include "base/splats/prefix_table.h"
#include "select/rule.h"

#include <assert.h>

enum {
    RUN_ALIGN = 64,
    RUN_GROWS = 8 ///< run lengths grow by an eighth of the splats before
};

#define ONE_DEPTH 1.02 ///< depth ranges below this ratio count as a single depth

// Candidates only sample the surface: the distance from the surface to a splat is at most the
// prefix's coverage radius plus the candidate radius. Few points are that far away. Adding the
// whole candidate radius to large splats would only extend them beyond edges.
#define ROOMY 2.0 ///< pixels up to which the whole candidate radius is added
#define CLOSE 4.0 ///< pixels from which half of it is added

/// Disk radius of a prefix when splats of this many pixels are wanted.
static void choose_prefix(stp_set_use* use, uint32_t count, double splat_size)
{
    assert(count <= use->splats->count);
    double roomy = (CLOSE - splat_size) / (CLOSE - ROOMY);
    double share = 0.5 + 0.5 * (roomy > 0.0 ? fmin(roomy, 1.0) : 0.0);
    use->count = count;
    use->radius = (double)stp_prefix_table_radius(&use->splats->table, count) +
                  share * (double)use->splats->candidate_radius;
}

/// p(r) = p_m (r_m / r)^2, Brandt 4.1.
static void choose_by_estimate(stp_set_use* use, double radius, bool cloud)
{
    const stp_splats* splats = use->splats;
    double ratio = (double)splats->paper_radius / radius;
    double wanted = ceil((double)splats->paper_count * ratio * ratio);
    if (!(wanted <= (double)splats->count) && !cloud) {
        return;
    }
    use->count = wanted < 1.0                     ? 1
                 : wanted < (double)splats->count ? (uint32_t)wanted
                                                  : splats->count;
    use->radius = radius;
    use->switch_depth = 0.0;
}

#define SHORT 2.0 ///< far over near depth up to which a node is opened slowly
#define LONG 3.0  ///< and from which it is opened early

/// Factor on the depth beyond which a node's set suffices, if the set is too coarse at the node's
/// nearest depth: the cube of the shortfall, up to its seventh power for nodes that are long in
/// depth. A long node is thus fully open before the eye enters its box. A short node lies at about
/// one depth and is replaced gradually.
static double switch_depth_factor(double lacks, stp_depth_range range)
{
    double length = (range.far / range.near - SHORT) / (LONG - SHORT);
    double part = length > 0.0 ? fmin(length, 1.0) : 0.0;
    double cubed = lacks * lacks * lacks;
    if (!(part > 0.0)) { // its fourth power may be infinite
        return cubed;
    }
    return cubed * (1.0 + part * (cubed * lacks - 1.0));
}

/// Chooses the prefix, and its radius, of a set in a level switch, so that it and the incoming content
/// together take at most STP_LEVEL_SWITCH_WORK times the work of the more expensive one. A shorter
/// prefix still covers, with larger splats.
static void choose_switching_prefix(stp_set_use* use, uint32_t count, double size, double below,
                                    double grown)
{
    assert(grown >= 0.0 && grown <= 1.0 && "a share");
    double own = STP_SPLAT_WORK * (double)count;
    double maximum = STP_LEVEL_SWITCH_WORK * fmax(own, below) - grown * below;
    if (maximum < own) {
        double part = (double)count * (maximum / own);
        count = part > 1.0 ? (uint32_t)part : 1;
    }
    choose_prefix(use, count, size);
}

/// Chooses by insertion radius: the surfels that cover at the nearest depth, or all if they do not
/// suffice. Opens the node if the wanted radius is finer than its surfels are used for.
static void choose_by_insertion(stp_set_use* use, const stp_selection* s,
                                const stp_box_visibility* sight, const stp_select_entry* at,
                                bool cloud)
{
    const stp_splats* splats = use->splats;
    stp_depth_range range = sight->range;
    double size = cloud ? 0.0 : sight->splat_size; // clouds are drawn at any distance, with gaps
    double suffices_from = stp_select_reach(s, at->node, sight->splat_size) / use->per_depth;
    double below = (double)s->graph->works[at->node];
    uint32_t count = stp_prefix_table_count(&splats->table, (float)(use->per_depth * range.near));
    bool suffices = cloud || range.near >= suffices_from;
    if (!suffices && s->quality->policy == STP_POLICY_SWITCH) {
        return;
    }
    if (cloud || (suffices && s->quality->policy == STP_POLICY_SWITCH)) {
        choose_prefix(use, count, size);
        use->switch_depth = 0.0;
        return;
    }
    if (suffices) {
        use->switch_depth = suffices_from;
        choose_switching_prefix(use, count, size, below,
                                stp_level_switch_share(suffices_from, range.near));
        return;
    }
    use->switch_depth = suffices_from * switch_depth_factor(suffices_from / range.near, range);
    use->in_level_switch = true;
    if (range.far * STP_LEVEL_SWITCH_NEAR > use->switch_depth) {
        choose_switching_prefix(use, count, size, below, 1.0);
    }
}

/// Share of a node's own set that is drawn at a depth.
static double set_switch_share(const stp_set_use* use, double depth)
{
    const double gone = 1.0 / STP_LEVEL_SWITCH_NEAR;
    return stp_clampd((depth / use->switch_depth - gone) / (1.0 - gone), 0.0, 1.0);
}

/// Bounds of the depths at which splat `index` of the prefix, and those after it, are drawn.
static stp_depth_range depths_of(const stp_set_use* use, double ancestor_switch_depth,
                                 uint32_t index)
{
    stp_depth_range range = {0.0, HUGE_VAL};
    assert(index < use->count);
    double part = (double)index / (double)use->count;
    if (use->in_level_switch) {
        const double gone = 1.0 / STP_LEVEL_SWITCH_NEAR;
        range.near = use->switch_depth * (gone + part * (1.0 - gone));
    }
    if (ancestor_switch_depth < HUGE_VAL) {
        range.far =
            ancestor_switch_depth * (STP_LEVEL_SWITCH_FAR - part * (STP_LEVEL_SWITCH_FAR - 1.0));
    }
    return range;
}

/// Estimates how many of `count` splats, spread evenly over `seen` and drawn within `drawn`, are
/// drawn beside another level.
static double count_extra(const stp_select_entry* at, const stp_set_use* use, stp_depth_range seen,
                          stp_depth_range drawn, uint32_t count)
{
    double low = fmax(seen.near, drawn.near), high = fmin(seen.far, drawn.far);
    double own = use->in_level_switch ? fmax(0.0, fmin(high, use->switch_depth) - low) : 0.0;
    double grown = fmax(0.0, high - fmax(low, at->ancestor_switch_depth));
    double width = fmax(seen.far - seen.near, 1e-12 * seen.far);
    return (double)count * fmin(1.0, (own + grown) / width);
}

/// Divides a prefix into runs; no runs if every splat is drawn at all depths of the node.
static stp_result add_runs(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                           stp_depth_range seen, stp_draw_item* item, double* extra)
{
    size_t first = s->list->run_count;
    bool needed = false;
    for (uint32_t begin = 0; begin < item->prefix;) {
        uint32_t left = item->prefix - begin;
        uint32_t size = begin / RUN_GROWS / RUN_ALIGN * RUN_ALIGN;
        size = size > RUN_ALIGN ? size : RUN_ALIGN;
        uint32_t end = left - 1 < size ? item->prefix : begin + size;
        assert(begin % RUN_ALIGN == 0 && begin < end && end <= item->prefix);
        stp_depth_range range = depths_of(use, at->ancestor_switch_depth, begin);
        *extra += count_extra(at, use, seen, range, end - begin);
        range.near = range.near <= seen.near ? 0.0 : range.near;
        range.far = range.far >= seen.far ? HUGE_VAL : range.far;
        bool whole = range.near <= 0.0 && range.far >= HUGE_VAL;
        needed = needed || !whole;
        if (whole && !needed && s->list->run_count > first) {
            s->list->runs[first].end = end;
        } else {
            stp_result result = stp_select_add_run(s, begin, end, range);
            if (result != STP_OK) {
                return result;
            }
        }
        begin = end;
    }
    if (!needed) {
        s->list->run_count = first;
        return STP_OK;
    }
    assert(s->list->runs[s->list->run_count - 1].end == item->prefix && "runs cover the prefix");
    if (s->list->run_count > UINT32_MAX) {
        return stp_fail(s->context, STP_ERROR_LIMIT, "view: too many runs of splats");
    }
    item->first_run = (uint32_t)first;
    item->run_count = (uint32_t)(s->list->run_count - first);
    return STP_OK;
}

static stp_result add(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_box_visibility* sight)
{
    stp_depth_range range = sight->range;
    double part = stp_level_switch_share(at->ancestor_switch_depth, range.near);
    part *= use->in_level_switch ? set_switch_share(use, range.far) : 1.0;
    assert(part >= 0.0 && part <= 1.0 && "a share");
    stp_draw_item item = {.kind = STP_DRAW_SPLATS,
                          .index = use->set,
                          .prefix = (uint32_t)(part * (double)use->count),
                          .full_prefix = use->count,
                          .radius = (float)use->radius,
                          .sections = at->sections,
                          .ghost = at->shown == STP_SHOW_GHOST,
                          .of_points = stp_select_is_of_points(s, at->node),
                          .transform = at->transform};
    bool flat = range.far < range.near * ONE_DEPTH;
    bool by_depth = use->per_depth > 0.0 && s->quality->policy == STP_POLICY_INSERTION;
    double extra = at->in_level_switch || use->in_level_switch ? (double)item.prefix : 0.0;
    if (by_depth && !flat && (use->in_level_switch || range.far > at->ancestor_switch_depth)) {
        extra = 0.0;
        stp_result result = add_runs(s, at, use, range, &item, &extra);
        if (result != STP_OK) {
            return result;
        }
    }
    s->list->extra_splats += (uint64_t)extra;
    return stp_select_add_item(s, item, item.prefix);
}

static void choose_count(stp_set_use* use, uint32_t count)
{
    choose_prefix(use, count, 0.0);
}

static void choose(const stp_selection* s, const stp_select_entry* at,
                   const stp_box_visibility* sight, bool cloud, stp_set_use* use)
{
    if (s->quality->policy == STP_POLICY_PAPER) {
        choose_by_estimate(use, use->per_depth * sight->range.near, cloud);
        use->per_depth = 0.0;
    } else {
        choose_by_insertion(use, s, sight, at, cloud);
    }
}

/// Uses splats large enough for the resident prefix.
static void limit(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use)
{
    (void)at;
    (void)nearest;
    if (use->count > here || use->count == 0) {
        use->count = here;
        use->radius = (double)stp_prefix_table_radius(&use->splats->table, here) +
                      (double)use->splats->candidate_radius;
    }
}

const stp_select_rule stp_select_rule_blue = {choose, choose_count, limit, add};
