// SPDX-License-Identifier: MIT
// Where levels meet: each splat of a set is drawn between two depths. Beyond the far one fewer suffice, or those of an
// ancestor do; nearer than the near one the node is opened.
#include "select/select_internal.h"

enum {
    RUN_ALIGN = 64,
    RUN_GROWS = 8 ///< runs grow by an eighth of what is before them
};

#define ONE_DEPTH 1.02 ///< what is seen at depths this alike is drawn as if it were at one

static double clamp_unit(double x)
{
    return x > 0.0 ? (x < 1.0 ? x : 1.0) : 0.0;
}

double stp_select_growth(double ceiling, double depth)
{
    if (depth <= ceiling) {
        return 1.0;
    }
    return clamp_unit((STP_LEVELS_GROW * ceiling - depth) / ((STP_LEVELS_GROW - 1.0) * ceiling));
}

/// How much of a node's own set is there at a depth.
static double shrinking(const stp_set_use* use, double depth)
{
    const double gone = 1.0 / STP_LEVELS_SHRINK;
    return clamp_unit((depth / use->switch_depth - gone) / (1.0 - gone));
}

/// The depths between which splat `index` of the prefix, and those after it, are drawn at most.
static stp_depth_range depths_of(const stp_set_use* use, double ceiling, uint32_t index)
{
    stp_depth_range range = {0.0, HUGE_VAL};
    double part = (double)index / (double)use->count;
    if (use->extra) {
        const double gone = 1.0 / STP_LEVELS_SHRINK;
        range.near = use->switch_depth * (gone + part * (1.0 - gone));
    }
    if (ceiling < HUGE_VAL) {
        range.far = ceiling * (STP_LEVELS_GROW - part * (STP_LEVELS_GROW - 1.0));
    }
    return range;
}

static stp_result add_run(stp_selection* s, uint32_t end, stp_depth_range range)
{
    stp_draw_list* list = s->list;
    if (list->run_count == list->run_capacity) {
        stp_draw_run* runs = stp_grow_array(s->context, list->runs, &list->run_capacity,
                                            list->run_count + 1, sizeof(*runs));
        if (runs == NULL) {
            return stp_fail_memory(s->context);
        }
        list->runs = runs;
    }
    // rounded outwards
    float nearest = (float)(range.near * (1.0 - 1e-6)), farthest = INFINITY;
    if (range.far < (double)FLT_MAX) {
        farthest = (float)(range.far * (1.0 + 1e-6));
    }
    list->runs[list->run_count++] =
        (stp_draw_run){.end = end, .nearest = nearest, .farthest = farthest};
    return STP_OK;
}

/// Splats [begin, end) of those that lie evenly spread over `seen`, that are drawn beside those of another level.
static double count_extra(const stp_select_entry* at, const stp_set_use* use, stp_depth_range seen,
                          stp_depth_range drawn, uint32_t count)
{
    double low = fmax(seen.near, drawn.near), high = fmin(seen.far, drawn.far);
    double own = use->extra ? fmax(0.0, fmin(high, use->switch_depth) - low) : 0.0;
    double grown = fmax(0.0, high - fmax(low, at->ceiling));
    double width = fmax(seen.far - seen.near, 1e-12 * seen.far);
    return (double)count * fmin(1.0, (own + grown) / width);
}

/// Divides a prefix into runs; none where each splat is drawn wherever the node is seen.
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
        stp_depth_range range = depths_of(use, at->ceiling, begin);
        *extra += count_extra(at, use, seen, range, end - begin);
        range.near = range.near <= seen.near ? 0.0 : range.near;
        range.far = range.far >= seen.far ? HUGE_VAL : range.far;
        bool whole = range.near <= 0.0 && range.far >= HUGE_VAL;
        needed = needed || !whole;
        if (whole && !needed && s->list->run_count > first) {
            s->list->runs[first].end = end;
        } else {
            stp_result result = add_run(s, end, range);
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
    if (s->list->run_count > UINT32_MAX) {
        return stp_fail(s->context, STP_ERROR_LIMIT, "view: too many runs of splats");
    }
    item->first_run = (uint32_t)first;
    item->run_count = (uint32_t)(s->list->run_count - first);
    return STP_OK;
}

stp_result stp_select_add_set(stp_selection* s, const stp_select_entry* at, const stp_set_use* use,
                              const stp_sight* sight)
{
    stp_depth_range range = sight->range;
    double part = stp_select_growth(at->ceiling, range.near);
    part *= use->extra ? shrinking(use, range.far) : 1.0;
    stp_draw_item item = {.kind = STP_DRAW_SURFELS,
                          .index = s->directory->nodes[at->node].surfels,
                          .prefix = (uint32_t)(part * (double)use->count),
                          .full_prefix = use->count,
                          .radius = (float)use->radius,
                          .sections = at->sections,
                          .ghost = at->shown == STP_SHOW_GHOST,
                          .transform = at->transform};
    bool flat = range.far < range.near * ONE_DEPTH;
    bool by_depth = use->per_depth > 0.0 && s->quality->policy == STP_POLICY_INSERTION;
    double extra = at->extra || use->extra ? (double)item.prefix : 0.0;
    if (by_depth && !flat && (use->extra || range.far > at->ceiling)) {
        extra = 0.0;
        stp_result result = add_runs(s, at, use, range, &item, &extra);
        if (result != STP_OK) {
            return result;
        }
    }
    s->list->extra_splats += (uint64_t)extra;
    return stp_select_add_item(s, item, item.prefix);
}
