// SPDX-License-Identifier: MIT
// Traversal of the graph: chooses the visible nodes and their levels.

#include "select/rule.h"
#include "select/select_internal.h"

#include <assert.h>

// A small graph of shared nodes can expand exponentially. These limits bound the time and memory of
// a view: a fixed allowance, plus a number per record of the graph. Views of real scenes visit
// about 100,000 nodes.
#define VISITS_ALWAYS (UINT64_C(1) << 21)
#define ITEMS_ALWAYS (UINT64_C(1) << 19)
#define EACH_RECORD UINT64_C(16)

static uint64_t limit_of(const stp_selection* s, uint64_t always)
{
    const stp_store_directory* d = s->directory;
    return always + EACH_RECORD * ((uint64_t)d->node_count + d->edge_count + d->part_count);
}

stp_result stp_select_count_visit(stp_selection* s)
{
    if (++s->visits > limit_of(s, VISITS_ALWAYS)) {
        return stp_fail(s->context, STP_ERROR_LIMIT,
                        "view: the scene's graph unfolds to more than %llu nodes",
                        (unsigned long long)limit_of(s, VISITS_ALWAYS));
    }
    return STP_OK;
}

stp_result stp_select_push(stp_selection* s, const stp_select_entry* entry)
{
    stp_draw_list* list = s->list;
    assert(entry->node < s->directory->node_count);
    assert(s->stack_count <= list->stack_capacity);
    if (s->stack_count == list->stack_capacity) {
        if (!STP_MAKE_ROOM(s->context, list->stack, list->stack_capacity, s->stack_count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    list->stack[s->stack_count++] = *entry;
    return STP_OK;
}

stp_result stp_select_add_item(stp_selection* s, stp_draw_item item, uint64_t id_count)
{
    stp_draw_list* list = s->list;
    uint64_t first = list->id_count;
    assert(item.prefix <= item.full_prefix);
    assert(item.split_count <= id_count && "parents are part of the prefix");
    assert((item.run_count == 0 || (size_t)item.first_run + item.run_count == list->run_count) &&
           "an item's runs are the last ones");
    if (id_count == 0) {
        return STP_OK;
    }
    if (first + id_count >= UINT32_MAX) {
        return stp_fail(s->context, STP_ERROR_LIMIT,
                        "view: more than 4294967294 splats and triangles would have to be drawn");
    }
    if (list->count >= limit_of(s, ITEMS_ALWAYS)) {
        return stp_fail(s->context, STP_ERROR_LIMIT,
                        "view: more than %zu objects would have to be drawn one by one",
                        list->count);
    }
    if (list->count == list->capacity) {
        if (!STP_MAKE_ROOM(s->context, list->items, list->capacity, list->count + 1)) {
            return stp_fail_memory(s->context);
        }
    }
    item.first_id = (uint32_t)first;
    list->items[list->count++] = item;
    list->id_count += id_count;
    if (!item.large) {
        uint64_t drawn = id_count - item.split_count;
        *(item.kind == STP_DRAW_MESH ? &list->triangle_count : &list->splat_count) += drawn;
    }
    return STP_OK;
}

stp_boxd stp_select_place_box(const stp_affine* a, const stp_boxd* box)
{
    if (stp_boxd_is_empty(*box)) {
        return *box;
    }
    stp_vec3d half = stp_scaled(stp_subd(box->max, box->min), 0.5);
    stp_vec3d center = stp_affine_point(a, stp_addd(box->min, half));
    const double(*m)[4] = a->m;
    stp_vec3d reach = {
        fabs(m[0][0]) * half.x + fabs(m[0][1]) * half.y + fabs(m[0][2]) * half.z,
        fabs(m[1][0]) * half.x + fabs(m[1][1]) * half.y + fabs(m[1][2]) * half.z,
        fabs(m[2][0]) * half.x + fabs(m[2][1]) * half.y + fabs(m[2][2]) * half.z,
    };
    return (stp_boxd){stp_subd(center, reach), stp_addd(center, reach)};
}

stp_boxd stp_select_part_box(const stp_selection* s, stp_store_part part, const stp_affine* a)
{
    assert(part.index < (part.kind == STP_STORE_PART_MESH ? s->directory->mesh_count
                                                          : s->directory->point_set_count));
    stp_box box = part.kind == STP_STORE_PART_MESH
                      ? stp_store_describe_mesh(s->store, part.index)->bounds
                      : stp_store_describe_point_set(s->store, part.index)->bounds;
    stp_boxd wide = {stp_to_double(box.min), stp_to_double(box.max)};
    return stp_select_place_box(a, &wide);
}

/// Adds a node's own triangles or points, up to the depth where its splats, or an ancestor's,
/// suffice.
static stp_result add_part(stp_selection* s, stp_store_part part, const stp_select_entry* at,
                           uint32_t shown)
{
    stp_draw_item item = {.index = part.index,
                          .sections = at->sections,
                          .ghost = shown == STP_SHOW_GHOST,
                          .transform = at->transform};
    uint64_t count;
    if (part.kind == STP_STORE_PART_MESH) {
        const stp_store_mesh* mesh = stp_store_describe_mesh(s->store, part.index);
        item.kind = STP_DRAW_MESH;
        count = mesh->triangle_count;
    } else {
        const stp_store_point_set* points = stp_store_describe_point_set(s->store, part.index);
        if (points->held_by != 0 && s->streams) {
            return STP_OK; // a set holds these points: they are loaded and drawn with it
        }
        item.kind = STP_DRAW_POINTS;
        // in a draft, a point set may stand for the mesh of a node without points
        item.of_points = s->directory->nodes[at->node].point_count > 0;
        item.prefix = item.full_prefix = points->point_count;
        count = points->point_count;
    }
    stp_boxd box = stp_select_part_box(s, part, &at->transform);
    stp_box_visibility sight;
    if (shown == STP_SHOW_NOT || !stp_select_is_in_view(s, &box, &sight) ||
        !stp_sections_test(s->sections, &box, 0.0, &item.sections) ||
        !(stp_level_switch_share(at->ancestor_switch_depth, sight.range.near) > 0.0)) {
        return STP_OK;
    }
    if (s->streams && !stp_select_request_part(s, part, at, &sight)) {
        return STP_OK;
    }
    stp_depth_range range = sight.range;
    if (item.kind == STP_DRAW_POINTS && range.near > at->ancestor_switch_depth) {
        return STP_OK; // no subset of them is spread evenly: they appear all at once, below splats
    }
    if (item.kind == STP_DRAW_MESH && range.far > at->ancestor_switch_depth) {
        item.switch_begin = (float)at->ancestor_switch_depth;
        item.switch_end = (float)(at->ancestor_switch_depth * STP_LEVEL_SWITCH_FAR);
        double end = fmin(range.far, at->ancestor_switch_depth * STP_LEVEL_SWITCH_FAR);
        double width = fmax(range.far - range.near, 1e-12 * range.far);
        double beside = fmin(1.0, (end - fmax(range.near, at->ancestor_switch_depth)) / width);
        double share = stp_level_switch_share(at->ancestor_switch_depth,
                                              fmax(range.near, at->ancestor_switch_depth));
        s->list->extra_triangles += (uint64_t)((double)count * beside * 0.5 * share);
    }
    return stp_select_add_item(s, item, count);
}

/// Visibility state of an edge or part of a node.
static uint32_t show_below(const stp_selection* s, const stp_select_entry* at, uint32_t slot)
{
    return stp_show_of(at->shown) == STP_SHOW_MIXED
               ? stp_visibility_below(s->quality->visibility, at->shown, slot)
               : at->shown;
}

/// The depth beyond which a part is not drawn, because something of an ancestor stands for it.
static double switch_depth_of(const stp_selection* s, stp_store_part part,
                              const stp_select_entry* at)
{
    bool leveled = at->level_depth < HUGE_VAL && stp_select_replaces_part(s, part);
    return leveled ? fmin(at->ancestor_switch_depth, at->level_depth) : at->ancestor_switch_depth;
}

static stp_result open_node(stp_selection* s, const stp_select_entry* at)
{
    const stp_store_directory* directory = s->directory;
    const stp_store_node* node = &directory->nodes[at->node];
    stp_result result = STP_OK;
    bool mixed = stp_show_of(at->shown) == STP_SHOW_MIXED;
    for (uint32_t i = 0; i < node->part_count && !at->moving_only && result == STP_OK; ++i) {
        uint32_t k = node->first_part + i;
        stp_store_part part = directory->parts[k];
        bool repeated = (s->graph->repeated[k / 8] >> k % 8 & 1) != 0;
        if (mixed || !repeated) { // drawing a part again would change no pixel
            stp_select_entry own = *at;
            own.ancestor_switch_depth = switch_depth_of(s, part, at);
            result = add_part(s, part, &own, show_below(s, at, node->edge_count + i));
        }
    }
    for (uint32_t i = node->edge_count; i-- > 0 && result == STP_OK;) {
        const stp_store_edge* edge = &directory->edges[node->first_edge + i];
        assert(edge->node < at->node && "children come before their parents");
        if (at->moving_only && s->graph->moving[edge->node] == 0) {
            continue;
        }
        stp_select_entry below = *at;
        below.node = edge->node;
        below.shown = show_below(s, at, i);
        below.transform = stp_affine_multiply(at->transform, edge->transform);
        result = stp_select_push(s, &below);
    }
    return result;
}

/// Whether hidden objects and sections leave any of a box visible. Drops sections that cannot cut
/// it.
static bool is_left(const stp_selection* s, stp_select_entry* at, const stp_boxd* box)
{
    if (at->shown == STP_SHOW_NOT) {
        return false;
    }
    if (at->sections == 0) {
        return true;
    }
    double margin = (double)s->graph->margins[at->node] * stp_affine_scale(&at->transform);
    return stp_sections_test(s->sections, box, margin, &at->sections);
}

/// Whether a node may be drawn by its set: it has one, no ancestor's set represents it, its
/// visibility is not mixed, and points need not be drawn separately.
static bool may_use_set(const stp_selection* s, const stp_select_entry* at)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    if (s->quality->points_apart && node->point_count > 0 && node->triangle_count > 0) {
        return false;
    }
    return stp_show_of(at->shown) != STP_SHOW_MIXED && !at->moving_only &&
           stp_select_set_of(s, at->node) != STP_STORE_NONE;
}

/// Visits a node for a splat count: registers sets whether in view or not, and draws only moving
/// nodes below a set.
static stp_result visit_by_count(stp_selection* s, stp_select_entry* at, bool seen)
{
    stp_result result = STP_OK;
    if (may_use_set(s, at) &&
        stp_store_describe_splat_set(s->store, stp_select_set_of(s, at->node))->count > 0) {
        result = stp_select_note_set(s, at);
        at->moving_only = true;
        at->ancestor_switch_depth = 0.0;
    }
    bool needed = !at->moving_only || (s->graph->moving[at->node] & STP_MOVES_BELOW) != 0;
    needed = needed && (seen || s->graph->has_sets[at->node]);
    return result == STP_OK && needed ? open_node(s, at) : result;
}

static stp_result visit(stp_selection* s, stp_select_entry* at)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    uint8_t moving = s->graph->moving[at->node];
    stp_result counted = stp_select_count_visit(s);
    if (counted != STP_OK) {
        return counted;
    }
    if ((moving & STP_NODE_MOVES) != 0) { // no ancestor represents it
        at->moving_only = at->in_level_switch = false;
        at->ancestor_switch_depth = at->level_depth = at->covered = HUGE_VAL;
        at->eager = 1.0;
    }
    s->list->node_count += 1;
    stp_boxd box = stp_select_place_box(&at->transform, &node->bounds);
    stp_box_visibility sight;
    bool seen = stp_select_is_in_view(s, &box, &sight);
    if (s->quality->splat_count > 0 && !s->quality->reference) {
        return is_left(s, at, &box) ? visit_by_count(s, at, seen) : STP_OK;
    }
    if (!seen || !is_left(s, at, &box)) {
        return STP_OK;
    }
    double nearest = sight.range.near;
    at->moving_only =
        at->moving_only || !(stp_level_switch_share(at->ancestor_switch_depth, nearest) > 0.0);
    bool hidden = false;
    if (at->moving_only && (moving & STP_MOVES_BELOW) == 0) {
        return STP_OK;
    }
    stp_result result = stp_select_hide(s, at, &box, &sight, &hidden);
    if (result != STP_OK || hidden) {
        return result;
    }
    bool leveled = at->level_depth < HUGE_VAL;
    if (leveled && !s->graph->others[at->node] && (moving & STP_MOVES_BELOW) == 0 &&
        !(stp_level_switch_share(at->level_depth, nearest) > 0.0)) {
        return STP_OK;
    }
    if (may_use_set(s, at) && !s->quality->reference && !leveled) {
        stp_set_use use = stp_select_choose_use(s, at, &sight);
        result = s->streams ? stp_select_limit_use(s, at, &sight, &use) : STP_OK;
        if (use.count > 0 && result == STP_OK) {
            stp_set_use drawn = use;
            stp_select_choose_coarse(s, at, &sight, &drawn);
            result = drawn.rule->add(s, at, &drawn, &sight);
        }
        // if this node's splats suffice at its nearest depth, switching would draw nothing below
        at->in_level_switch = at->in_level_switch || (use.count > 0 && !use.in_level_switch);
        at->ancestor_switch_depth = fmin(at->ancestor_switch_depth, use.switch_depth);
        at->moving_only = !(stp_level_switch_share(at->ancestor_switch_depth, nearest) > 0.0);
        assert(use.count <= use.splats->count);
        if (s->streams && use.splats->count > 0) {
            stp_select_cover(s, use.splats, &sight, at);
        }
    }
    if (result != STP_OK || (at->moving_only && (moving & STP_MOVES_BELOW) == 0)) {
        return result;
    }
    if (!at->moving_only && !leveled) {
        result = stp_select_use_levels(s, at, &sight);
    }
    return result == STP_OK ? open_node(s, at) : result;
}

stp_result stp_select_traverse(stp_selection* s)
{
    stp_result result = STP_OK;
    while (result == STP_OK && s->stack_count > 0) {
        stp_select_entry at = s->list->stack[--s->stack_count];
        result = visit(s, &at);
    }
    return result;
}
