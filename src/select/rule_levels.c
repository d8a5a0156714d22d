// SPDX-License-Identifier: MIT
// Sets whose splats have ranges of levels, `spt` and `psp`: a view takes the prefix whose ranges
// reach the nearest depth; backends test each splat when drawing (Dachsbacher et al. 2003, 3.6 and
// 3.7). If all splats of a set do not suffice, the node is opened. Sets of `psp` have states with
// any requested number of splats (Wu et al. 2005, 5).
#include "base/splats/prefix_table.h"
#include "select/rule.h"

#include <assert.h>

/// Shortest prefix of the table that holds every splat a level can need.
static uint32_t find_prefix(const stp_splats* splats, double level)
{
    const stp_prefix_table* table = &splats->table;
    for (uint32_t i = 0; i < table->size; ++i) {
        if ((double)table->radius[i] <= level) {
            return table->count[i];
        }
    }
    return splats->count;
}

/// The highest level of any splat after the first `count`. At this level and above, the prefix is
/// complete.
static double find_level(const stp_splats* splats, uint32_t count)
{
    const stp_prefix_table* table = &splats->table;
    double level = table->size != 0 ? (double)table->radius[0] : 0.0;
    for (uint32_t i = 0; i < table->size && table->count[i] <= count; ++i) {
        level = (double)table->radius[i];
    }
    return count < splats->count ? level : 0.0;
}

/// Uses one level for the whole set: an exact cut through the tree.
static void choose_count(stp_set_use* use, uint32_t count)
{
    assert(count <= use->splats->count);
    use->count = count;
    use->level_min = find_level(use->splats, count);
    use->radius = fmax(use->level_min, (double)use->splats->candidate_radius);
}

/// Uses the state with `count` splats. It is contained in the first 2 count - base splats, and a
/// base set has at least one.
static void choose_state(stp_set_use* use, uint32_t count)
{
    uint32_t all = use->splats->count;
    assert(count > 0 && "a base set has at least one splat");
    choose_count(use, count <= all / 2 ? 2 * count - 1 : all);
    use->state = count;
}

/// The prefix for views from `nearest` on.
static void choose_from(const stp_select_entry* at, double nearest, stp_set_use* use)
{
    assert(use->per_depth > 0.0 && "drawn by size");
    use->count = find_prefix(use->splats, use->per_depth * nearest);
    use->radius = use->per_depth * nearest;
    use->level_per_depth = use->per_depth;
    use->level_min = 0.0;
    if (use->per_depth * stp_affine_scale(&at->transform) > (double)STP_LEVEL_SLOPE) {
        use->level_per_depth = 0.0; // ranges do not overlap so far
        use->level_min = use->per_depth * nearest;
    }
}

static void limit(const stp_select_entry* at, double nearest, uint32_t here, stp_set_use* use)
{
    if (use->per_depth > 0.0) {
        choose_from(at, nearest, use);
    }
    if (use->count > here || use->count == 0) {
        use->count = here;
        use->level_min = fmax(use->level_min, find_level(use->splats, here));
        use->radius = fmax(use->radius, use->level_min);
    }
}

static void choose(const stp_selection* s, const stp_select_entry* at,
                   const stp_box_visibility* sight, bool cloud, stp_set_use* use)
{
    double nearest;
    if (stp_select_find_nearest(s, at, sight, cloud, use, &nearest)) {
        choose_from(at, nearest, use);
    }
}

/// Uses the first splats: `count`, or fewer if `use` has fewer.
static void choose_at_most(stp_set_use* use, uint32_t count)
{
    choose_count(use, count < use->count ? count : use->count);
}

static stp_draw_item make_item(const stp_selection* s, const stp_select_entry* at,
                               const stp_set_use* use)
{
    stp_draw_item item = stp_select_splat_item(s, at, use);
    item.level_per_depth = (float)use->level_per_depth;
    item.level_min = (float)use->level_min;
    return item;
}

static stp_result add(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                      const stp_box_visibility* sight)
{
    stp_draw_item item = make_item(s, at, use);
    bool found = true;
    stp_result result = use->state > 0 ? stp_select_cut_item(s, use->state, &item, &found) : STP_OK;
    if (result != STP_OK) {
        return result;
    }
    if (!found) {
        stp_set_use less = *use;
        choose_at_most(&less, use->state);
        item = make_item(s, at, &less);
    }
    result = stp_select_choose_triangles(s, at, use, sight, &item.beside_triangles);
    if (result != STP_OK) {
        return result;
    }
    stp_depth_range drawn = {use->in_level_switch ? use->switch_depth : 0.0,
                             at->ancestor_switch_depth < HUGE_VAL
                                 ? at->ancestor_switch_depth * STP_LEVEL_SWITCH_FAR
                                 : HUGE_VAL};
    drawn.near = drawn.near <= sight->range.near ? 0.0 : drawn.near;
    drawn.far = drawn.far >= sight->range.far ? HUGE_VAL : drawn.far;
    if (drawn.near > 0.0 || drawn.far < HUGE_VAL) {
        size_t first = s->list->run_count;
        result = stp_select_add_run(s, 0, item.prefix, drawn);
        if (result != STP_OK) {
            return result;
        }
        item.first_run = (uint32_t)first;
        item.run_count = 1;
    }
    assert(item.split_count <= item.prefix);
    s->list->extra_splats +=
        at->in_level_switch || use->in_level_switch ? item.prefix - item.split_count : 0;
    result = stp_select_add_item(s, item, item.prefix);
    return result == STP_OK && item.beside_triangles ? stp_select_add_triangles(s, at, use, sight)
                                                     : result;
}

const stp_select_rule stp_select_rule_levels = {choose, choose_count, limit, add};
const stp_select_rule stp_select_rule_splits = {choose, choose_state, limit, add};
