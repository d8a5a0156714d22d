// SPDX-License-Identifier: MIT
// Selection for a streaming store: draws only resident data (store/residency/residency.h), without holes.
//
// A node is opened only if all visible content below it is resident: its parts, and enough octaves
// of each child's set to cover as well as the node's own set. Otherwise the resident prefix of its
// own set is drawn, with splats large enough for that prefix. So every visited node has something
// to draw, unless it has no stand-in. Data that a view draws or lacks is requested; the priority is
// the size of the stand-in's splats, relative to the wanted size.
#include "base/splats/prefix_table.h"
#include "select/rule.h"
#include "store/file/store.h"

#include <assert.h>

#define ROUNDED (1.0 + 1e-6)
#define EAGER_MAX 4.0
#define EXTRA_NEED 0.01f // less than the priority of items drawn too coarsely
#define UNSEEN_NEED 0.001f

stp_result stp_select_begin_requests(stp_selection* s)
{
    stp_draw_list* list = s->list;
    s->streams = stp_store_streams(s->store) && !s->quality->reference;
    for (size_t i = 0; i < list->request_count && !s->second_pass; ++i) {
        assert(list->requests[i].resource < list->want_capacity);
        list->request_slots[list->requests[i].resource] = 0;
    }
    list->request_count = s->second_pass ? list->request_count : 0;
    uint32_t resources = s->streams ? stp_store_resource_count(s->store) : 0;
    if (resources <= list->want_capacity) {
        return STP_OK;
    }
    stp_free(s->context, list->requests);
    stp_free(s->context, list->request_slots);
    list->want_capacity = 0;
    list->requests = STP_NEW_ARRAY(s->context, stp_data_request, resources);
    list->request_slots = STP_NEW_ZEROED(s->context, uint32_t, resources);
    if (list->requests == NULL || list->request_slots == NULL) {
        return stp_fail_memory(s->context);
    }
    list->want_capacity = resources;
    return STP_OK;
}

/// Size of splats of a radius (scene units), relative to the wanted size at the box's nearest
/// depth.
static float find_need(const stp_selection* s, const stp_box_visibility* sight, double radius)
{
    if (sight->eyes == 0) {
        return UNSEEN_NEED;
    }
    double pixel = stp_view_frame_pixel_size(&s->frames[0], sight->range.near);
    double need = radius / (0.5 * sight->splat_size * pixel);
    return need < (double)STP_NEED_MAX ? (float)need : STP_NEED_MAX;
}

static void add_request(stp_selection* s, stp_data_request request)
{
    stp_draw_list* list = s->list;
    request.resource = stp_store_resource(s->store, request.kind, request.index);
    assert(request.resource < list->want_capacity && "a slot for each resource");
    uint32_t* slot = &list->request_slots[request.resource];
    assert(*slot <= list->request_count);
    if (*slot == 0) {
        assert(list->request_count < list->want_capacity && "each resource once");
        list->requests[list->request_count++] = request;
        *slot = (uint32_t)list->request_count;
        return;
    }
    stp_data_request* known = &list->requests[*slot - 1];
    assert(known->kind == request.kind && known->index == request.index &&
           "a resource has one number");
    known->octaves = request.octaves > known->octaves ? request.octaves : known->octaves;
    known->need = fmaxf(known->need, request.need);
    known->octave_need = fmaxf(known->octave_need, request.octave_need);
}

bool stp_select_request_part(stp_selection* s, stp_store_part part, const stp_select_entry* at,
                             const stp_box_visibility* sight)
{
    bool is_mesh = part.kind == STP_STORE_PART_MESH;
    add_request(s, (stp_data_request){.kind = is_mesh ? STP_RESIDENT_MESH : STP_RESIDENT_POINTS,
                                      .index = part.index,
                                      .need = find_need(s, sight, at->covered * at->eager)});
    return is_mesh ? stp_store_is_mesh_resident(s->store, part.index)
                   : stp_store_are_points_resident(s->store, part.index);
}

bool stp_select_request_level(stp_selection* s, const stp_select_entry* at,
                              const stp_box_visibility* sight, uint32_t mesh, double error)
{
    double shown = fmin(error * stp_affine_scale(&at->transform), at->covered * at->eager);
    add_request(s, (stp_data_request){.kind = STP_RESIDENT_MESH,
                                      .index = mesh,
                                      .need = find_need(s, sight, shown)});
    return stp_store_is_mesh_resident(s->store, mesh);
}

bool stp_select_request_optional_mesh(stp_selection* s, uint32_t mesh)
{
    add_request(s,
                (stp_data_request){.kind = STP_RESIDENT_MESH, .index = mesh, .need = EXTRA_NEED});
    return stp_store_is_mesh_resident(s->store, mesh);
}

static void request_set(stp_selection* s, const stp_select_entry* at,
                        const stp_box_visibility* sight, uint32_t set, uint32_t octaves)
{
    double scale = stp_affine_scale(&at->transform);
    assert(octaves <= stp_store_describe_splat_set(s->store, set)->octave_count);
    add_request(s, (stp_data_request){.kind = STP_RESIDENT_SPLATS,
                                      .index = set,
                                      .octaves = octaves,
                                      .need = find_need(s, sight, at->covered * at->eager),
                                      .octave_need = find_need(s, sight, scale)});
}

void stp_select_request_leaves(stp_selection* s, const stp_select_entry* at,
                               const stp_box_visibility* sight, uint32_t set)
{
    if (s->streams && stp_store_leaf_count(s->store, set) > 0) {
        add_request(s, (stp_data_request){.kind = STP_RESIDENT_LEAVES,
                                          .index = set,
                                          .need = find_need(s, sight, at->covered * at->eager)});
    }
}

static double radius_of(const stp_splats* splats, uint32_t count)
{
    return (double)stp_prefix_table_radius(&splats->table, count);
}

void stp_select_cover(const stp_selection* s, const stp_splats* splats,
                      const stp_box_visibility* sight, stp_select_entry* at)
{
    double reach = fmax(radius_of(splats, splats->count), (double)splats->candidate_radius);
    at->covered = reach * stp_affine_scale(&at->transform);
    // If a set is much too coarse, its finest octaves, which are most of its data, can come later.
    at->eager = fmin(fmax((double)find_need(s, sight, at->covered), 1.0), EAGER_MAX);
}

/// Whether the resident part of a set covers as well as its ancestors.
static bool replaces_ancestors(const stp_splats* splats, uint32_t here, const stp_select_entry* at)
{
    return here > 0 &&
           (here >= splats->count ||
            radius_of(splats, here) * stp_affine_scale(&at->transform) <= at->covered * ROUNDED);
}

/// Number of octaves that cover as well as the ancestors.
static uint32_t find_octaves(const stp_splats* splats, const stp_select_entry* at)
{
    uint32_t octaves = splats->octave_count > 0 ? 1 : 0;
    while (octaves < splats->octave_count &&
           !replaces_ancestors(splats, splats->octave_ends[octaves - 1], at)) {
        octaves += 1;
    }
    return octaves;
}

static stp_result push_children(stp_selection* s, const stp_select_entry* at)
{
    const stp_store_node* node = &s->directory->nodes[at->node];
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < node->edge_count && result == STP_OK; ++i) {
        const stp_store_edge* edge = &s->directory->edges[node->first_edge + i];
        if ((s->graph->moving[edge->node] & STP_NODE_MOVES) == 0) { // moving nodes are always drawn
            stp_select_entry below = *at;
            below.node = edge->node;
            below.transform = stp_affine_multiply(at->transform, edge->transform);
            result = stp_select_push(s, &below);
        }
    }
    return result;
}

stp_result stp_select_request_meshes(stp_selection* s, const stp_select_entry* top, bool replaced,
                                     double to, bool* here)
{
    size_t base = s->stack_count;
    stp_result result = stp_select_push(s, top);
    *here = true;
    while (s->stack_count > base && result == STP_OK) {
        stp_select_entry at = s->list->stack[--s->stack_count];
        const stp_store_node* node = &s->directory->nodes[at.node];
        stp_boxd box = stp_select_place_box(&at.transform, &node->bounds);
        stp_box_visibility sight;
        result = stp_select_count_visit(s);
        if (result != STP_OK || (!replaced && !s->graph->others[at.node]) ||
            !stp_select_is_in_view(s, &box, &sight) ||
            !(stp_level_switch_share(to, sight.range.near) > 0.0)) {
            continue;
        }
        for (uint32_t i = 0; i < node->part_count; ++i) {
            stp_store_part part = s->directory->parts[node->first_part + i];
            box = stp_select_part_box(s, part, &at.transform);
            if (stp_select_replaces_part(s, part) == replaced &&
                stp_select_is_in_view(s, &box, &sight) &&
                stp_level_switch_share(to, sight.range.near) > 0.0) {
                *here = stp_select_request_part(s, part, &at, &sight) && *here;
            }
        }
        result = push_children(s, &at);
    }
    s->stack_count = base;
    return result;
}

/// Requests the visible parts of a node, or the levels that stand for all below it, and pushes its
/// children except moving ones. Clears `*ready` if any of it is not resident.
static stp_result request_below(stp_selection* s, const stp_select_entry* at, bool* ready)
{
    const stp_store_directory* directory = s->directory;
    const stp_store_node* node = &directory->nodes[at->node];
    bool here = false;
    if (stp_select_request_levels(s, at, &here)) {
        bool others = true;
        stp_result result = stp_select_request_meshes(s, at, false, HUGE_VAL, &others);
        *ready = *ready && here && others;
        return result;
    }
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = directory->parts[node->first_part + i];
        stp_boxd box = stp_select_part_box(s, part, &at->transform);
        stp_box_visibility sight;
        if (stp_select_is_in_view(s, &box, &sight)) {
            bool loaded = stp_select_request_part(s, part, at, &sight);
            *ready = *ready && loaded;
        }
    }
    return push_children(s, at);
}

/// Whether everything visible below a node is resident. Requests what is missing.
static stp_result check_ready(stp_selection* s, const stp_select_entry* node,
                              const stp_splats* splats_of_node, const stp_box_visibility* seen,
                              bool* ready)
{
    size_t base = s->stack_count;
    stp_select_entry first = *node;
    stp_select_cover(s, splats_of_node, seen, &first);
    *ready = true;
    stp_result result = request_below(s, &first, ready);
    while (s->stack_count > base && result == STP_OK) {
        stp_select_entry at = s->list->stack[--s->stack_count];
        assert(at.node < node->node && "descendants come before their ancestors");
        const stp_store_node* below = &s->directory->nodes[at.node];
        stp_boxd box = stp_select_place_box(&at.transform, &below->bounds);
        stp_box_visibility sight;
        result = stp_select_count_visit(s);
        if (result != STP_OK || !stp_select_is_in_view(s, &box, &sight)) {
            continue;
        }
        uint32_t set = stp_select_set_of(s, at.node);
        const stp_splats* splats =
            set != STP_STORE_NONE ? stp_store_describe_splat_set(s->store, set) : NULL;
        if (splats == NULL || splats->count == 0) {
            result = request_below(s, &at, ready);
            continue;
        }
        request_set(s, &at, &sight, set, find_octaves(splats, &at));
        *ready =
            *ready && replaces_ancestors(splats, stp_store_resident_splats(s->store, set), &at);
    }
    s->stack_count = base;
    return result;
}

/// Reduces a use to the resident prefix, with splats large enough for it.
static void limit(const stp_selection* s, const stp_select_entry* at,
                  const stp_box_visibility* sight, uint32_t here, bool closes, stp_set_use* use)
{
    if (closes) {
        use->switch_depth = 0.0;
        use->in_level_switch = false;
    }
    s->rule->limit(at, use->in_level_switch ? use->switch_depth : sight->range.near, here, use);
    assert(use->count <= here && "only loaded splats are drawn");
}

stp_result stp_select_limit_use(stp_selection* s, const stp_select_entry* at,
                                const stp_box_visibility* sight, stp_set_use* use)
{
    const stp_splats* splats = use->splats;
    uint32_t here = stp_store_resident_splats(s->store, use->set);
    assert(here <= splats->count && "loaded splats are a prefix of the set");
    uint32_t octaves = stp_store_octaves_for(splats, use->count);
    uint32_t minimum = find_octaves(splats, at);
    bool opens = s->quality->splat_count == 0 &&
                 stp_level_switch_share(use->switch_depth, sight->range.near) > 0.0;
    bool ready = false;
    if (splats->count == 0) {
        return STP_OK;
    }
    if (opens) {
        stp_result result = check_ready(s, at, splats, sight, &ready);
        if (result != STP_OK) {
            return result;
        }
    }
    if (opens && !ready) {
        request_set(s, at, sight, use->set, splats->octave_count);
        limit(s, at, sight, here, true, use);
        return STP_OK;
    }
    if (use->count > 0 || opens) {
        request_set(s, at, sight, use->set, octaves > minimum ? octaves : minimum);
    }
    if (use->count <= here) {
        return STP_OK;
    }
    if (opens && !replaces_ancestors(splats, here, at)) { // everything below is resident
        use->count = 0;
        use->in_level_switch = false;
        use->switch_depth = HUGE_VAL;
        return STP_OK;
    }
    limit(s, at, sight, here, !opens, use);
    return STP_OK;
}

bool stp_select_request_coarse(stp_selection* s, const stp_select_entry* at,
                               const stp_box_visibility* sight, const stp_set_use* use)
{
    request_set(s, at, sight, use->set, stp_store_octaves_for(use->splats, use->count));
    return stp_store_resident_splats(s->store, use->set) >= use->count;
}
