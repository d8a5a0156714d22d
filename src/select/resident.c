// SPDX-License-Identifier: MIT
// Selection for a streaming store: draws only resident data (store/residency.h), without holes.
//
// A node is opened only if all visible content below it is resident: its parts, and enough octaves
// of each child's set to cover as well as the node's own set. Otherwise the resident prefix of its
// own set is drawn, with splats large enough for that prefix. So every visited node has something
// to draw, unless it has no stand-in. Data that a view draws or lacks is requested; the priority is
// the size of the stand-in's splats, relative to the wanted size.
#include "base/prefix_table.h"
#include "select/rule.h"
#include "store/leaves.h"

#define ROUNDED (1.0 + 1e-6)
#define EAGER_MOST 4.0
#define EXTRA_NEED 0.01f // less than the priority of items drawn too coarsely
#define UNSEEN_NEED 0.001f

stp_result stp_select_begin_wants(stp_selection* s)
{
    stp_draw_list* list = s->list;
    s->streams = stp_store_streams(s->store) && !s->quality->reference;
    for (size_t i = 0; i < list->want_count && !s->second_pass; ++i) {
        list->want_slots[list->wants[i].thing] = 0;
    }
    list->want_count = s->second_pass ? list->want_count : 0;
    uint32_t things = s->streams ? stp_store_thing_count(s->store) : 0;
    if (things <= list->want_capacity) {
        return STP_OK;
    }
    stp_free(s->context, list->wants);
    stp_free(s->context, list->want_slots);
    list->want_capacity = 0;
    list->wants = STP_NEW_ARRAY(s->context, stp_want, things);
    list->want_slots = STP_NEW_ZEROED(s->context, uint32_t, things);
    if (list->wants == NULL || list->want_slots == NULL) {
        return stp_fail_memory(s->context);
    }
    list->want_capacity = things;
    return STP_OK;
}

/// Size of splats of a radius (scene units), relative to the wanted size at the box's nearest
/// depth.
static float find_need(const stp_selection* s, const stp_sight* sight, double radius)
{
    if (sight->eyes == 0) {
        return UNSEEN_NEED;
    }
    double pixel = stp_view_frame_pixel_size(&s->frames[0], sight->range.near);
    double need = radius / (0.5 * sight->splat_size * pixel);
    return need < (double)STP_NEED_MOST ? (float)need : STP_NEED_MOST;
}

static void add_want(stp_selection* s, stp_want want)
{
    stp_draw_list* list = s->list;
    want.thing = stp_store_thing(s->store, want.kind, want.index);
    uint32_t* slot = &list->want_slots[want.thing];
    if (*slot == 0) {
        list->wants[list->want_count++] = want;
        *slot = (uint32_t)list->want_count;
        return;
    }
    stp_want* known = &list->wants[*slot - 1];
    known->octaves = want.octaves > known->octaves ? want.octaves : known->octaves;
    known->need = fmaxf(known->need, want.need);
    known->octave_need = fmaxf(known->octave_need, want.octave_need);
}

bool stp_select_want_part(stp_selection* s, stp_store_part part, const stp_select_entry* at,
                          const stp_sight* sight)
{
    bool is_mesh = part.kind == STP_STORE_PART_MESH;
    add_want(s, (stp_want){.kind = is_mesh ? STP_RESIDENT_MESH : STP_RESIDENT_POINTS,
                           .index = part.index,
                           .need = find_need(s, sight, at->covered * at->eager)});
    return is_mesh ? stp_store_is_mesh_resident(s->store, part.index)
                   : stp_store_are_points_resident(s->store, part.index);
}

bool stp_select_want_extra(stp_selection* s, uint32_t mesh)
{
    add_want(s, (stp_want){.kind = STP_RESIDENT_MESH, .index = mesh, .need = EXTRA_NEED});
    return stp_store_is_mesh_resident(s->store, mesh);
}

static void want_set(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                     uint32_t set, uint32_t octaves)
{
    double scale = stp_affine_scale(&at->transform);
    add_want(s, (stp_want){.kind = STP_RESIDENT_SURFELS,
                           .index = set,
                           .octaves = octaves,
                           .need = find_need(s, sight, at->covered * at->eager),
                           .octave_need = find_need(s, sight, scale)});
}

void stp_select_want_leaves(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                            uint32_t set)
{
    if (s->streams && stp_store_leaf_count(s->store, set) > 0) {
        add_want(s, (stp_want){.kind = STP_RESIDENT_LEAVES,
                               .index = set,
                               .need = find_need(s, sight, at->covered * at->eager)});
    }
}

static double radius_of(const stp_splats* surfels, uint32_t count)
{
    return (double)stp_prefix_table_radius(&surfels->table, count);
}

void stp_select_cover(const stp_selection* s, const stp_splats* surfels, const stp_sight* sight,
                      stp_select_entry* at)
{
    double reach = fmax(radius_of(surfels, surfels->count), (double)surfels->candidate_radius);
    at->covered = reach * stp_affine_scale(&at->transform);
    // If a set is much too coarse, its finest octaves, which are most of its data, can come later.
    at->eager = fmin(fmax((double)find_need(s, sight, at->covered), 1.0), EAGER_MOST);
}

/// Whether the resident part of a set covers as well as its ancestors.
static bool stands_in(const stp_splats* surfels, uint32_t here, const stp_select_entry* at)
{
    return here > 0 &&
           (here >= surfels->count ||
            radius_of(surfels, here) * stp_affine_scale(&at->transform) <= at->covered * ROUNDED);
}

/// Number of octaves that cover as well as the ancestors.
static uint32_t find_octaves(const stp_splats* surfels, const stp_select_entry* at)
{
    uint32_t octaves = surfels->octave_count > 0 ? 1 : 0;
    while (octaves < surfels->octave_count &&
           !stands_in(surfels, surfels->octave_ends[octaves - 1], at)) {
        octaves += 1;
    }
    return octaves;
}

/// Requests the visible parts of a node, and pushes its children. @return whether the parts are
/// resident
static stp_result request_below(stp_selection* s, const stp_select_entry* at, bool* ready)
{
    const stp_store_directory* directory = s->directory;
    const stp_store_node* node = &directory->nodes[at->node];
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = directory->parts[node->first_part + i];
        stp_boxd box = stp_select_part_box(s, part, &at->transform);
        stp_sight sight;
        if (stp_select_see(s, &box, &sight)) {
            bool here = stp_select_want_part(s, part, at, &sight);
            *ready = *ready && here;
        }
    }
    for (uint32_t i = 0; i < node->edge_count && result == STP_OK; ++i) {
        const stp_store_edge* edge = &directory->edges[node->first_edge + i];
        if ((s->graph->moving[edge->node] & STP_NODE_MOVES) == 0) { // moving nodes are always drawn
            stp_select_entry below = *at;
            below.node = edge->node;
            below.transform = stp_affine_multiply(at->transform, edge->transform);
            result = stp_select_push(s, &below);
        }
    }
    return result;
}

/// Whether everything visible below a node is resident. Requests what is missing.
static stp_result check_ready(stp_selection* s, const stp_select_entry* node,
                              const stp_splats* surfels_of_node, const stp_sight* seen, bool* ready)
{
    size_t base = s->stack_count;
    stp_select_entry first = *node;
    stp_select_cover(s, surfels_of_node, seen, &first);
    *ready = true;
    stp_result result = request_below(s, &first, ready);
    while (s->stack_count > base && result == STP_OK) {
        stp_select_entry at = s->list->stack[--s->stack_count];
        const stp_store_node* below = &s->directory->nodes[at.node];
        stp_boxd box = stp_select_place_box(&at.transform, &below->bounds);
        stp_sight sight;
        result = stp_select_count_visit(s);
        if (result != STP_OK || !stp_select_see(s, &box, &sight)) {
            continue;
        }
        uint32_t set = stp_select_set_of(s, at.node);
        const stp_splats* surfels =
            set != STP_STORE_NONE ? stp_store_describe_surfels(s->store, set) : NULL;
        if (surfels == NULL || surfels->count == 0) {
            result = request_below(s, &at, ready);
            continue;
        }
        want_set(s, &at, &sight, set, find_octaves(surfels, &at));
        *ready = *ready && stands_in(surfels, stp_store_resident_surfels(s->store, set), &at);
    }
    s->stack_count = base;
    return result;
}

/// Reduces a use to the resident prefix, with splats large enough for it.
static void limit(const stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                  uint32_t here, bool closes, stp_set_use* use)
{
    if (closes) {
        use->switch_depth = 0.0;
        use->extra = false;
    }
    s->rule->limit(at, use->extra ? use->switch_depth : sight->range.near, here, use);
}

stp_result stp_select_limit_use(stp_selection* s, const stp_select_entry* at,
                                const stp_sight* sight, stp_set_use* use)
{
    const stp_splats* surfels = use->surfels;
    uint32_t here = stp_store_resident_surfels(s->store, use->set);
    uint32_t octaves = stp_store_octaves_for(surfels, use->count);
    uint32_t least = find_octaves(surfels, at);
    bool opens = s->quality->splat_count == 0 &&
                 stp_select_growth(use->switch_depth, sight->range.near) > 0.0;
    bool ready = false;
    if (surfels->count == 0) {
        return STP_OK;
    }
    if (opens) {
        stp_result result = check_ready(s, at, surfels, sight, &ready);
        if (result != STP_OK) {
            return result;
        }
    }
    if (opens && !ready) {
        want_set(s, at, sight, use->set, surfels->octave_count);
        limit(s, at, sight, here, true, use);
        return STP_OK;
    }
    if (use->count > 0 || opens) {
        want_set(s, at, sight, use->set, octaves > least ? octaves : least);
    }
    if (use->count <= here) {
        return STP_OK;
    }
    if (opens && !stands_in(surfels, here, at)) { // everything below is resident
        use->count = 0;
        use->extra = false;
        use->switch_depth = HUGE_VAL;
        return STP_OK;
    }
    limit(s, at, sight, here, !opens, use);
    return STP_OK;
}

bool stp_select_want_coarse(stp_selection* s, const stp_select_entry* at, const stp_sight* sight,
                            const stp_set_use* use)
{
    want_set(s, at, sight, use->set, stp_store_octaves_for(use->surfels, use->count));
    return stp_store_resident_surfels(s->store, use->set) >= use->count;
}
