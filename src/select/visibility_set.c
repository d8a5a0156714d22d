// SPDX-License-Identifier: MIT
// Finds an object in the graph: descends from the root into nodes that overlap its place and share
// content with it, until a node belongs to it entirely.
#include "base/core/context.h"
#include "select/visibility_internal.h"
#include "store/file/instances.h"

#include <assert.h>
#include <string.h>

enum {
    OF_PLACED = 1, ///< the object's own node, or below it
    TOUCHES = 2,   ///< shares a part with the object
};

static const uint64_t visit_limit = UINT64_C(1) << 22; // plus 16 per record of the graph

typedef struct setting {
    stp_visibility* v;
    const stp_placed_node* placed;
    stp_boxd bounds; ///< bounds of the object, scene space
    uint32_t show;
    uint64_t visits; ///< remaining steps
    stp_result result;
} setting;

static size_t part_number(const setting* s, stp_store_part part)
{
    return part.kind == STP_STORE_PART_MESH ? part.index
                                            : (size_t)s->v->directory->mesh_count + part.index;
}

/// Marks nodes below the object's node, and nodes that share parts with it. Children come before
/// their parents.
static stp_result mark_nodes(setting* s)
{
    stp_visibility* v = s->v;
    const stp_store_directory* d = v->directory;
    size_t parts = (size_t)d->mesh_count + d->point_set_count;
    if (v->marks == NULL) {
        v->marks = STP_NEW_ARRAY(v->context, uint8_t, (size_t)d->node_count + 1);
    }
    if (v->has_parts == NULL) {
        v->has_parts = STP_NEW_ARRAY(v->context, uint8_t, parts + 1);
    }
    if (v->marks == NULL || v->has_parts == NULL) {
        return stp_fail_memory(v->context);
    }
    memset(v->marks, 0, d->node_count);
    memset(v->has_parts, 0, parts);
    v->marks[s->placed->node] = OF_PLACED | TOUCHES;
    for (uint32_t i = s->placed->node + 1; i-- > 0;) {
        const stp_store_node* n = &d->nodes[i];
        if (v->marks[i] == 0) {
            continue;
        }
        for (uint32_t k = 0; k < n->edge_count; ++k) {
            assert(d->edges[n->first_edge + k].node < i && "children come before their parents");
            v->marks[d->edges[n->first_edge + k].node] = OF_PLACED | TOUCHES;
        }
        for (uint32_t k = 0; k < n->part_count; ++k) {
            v->has_parts[part_number(s, d->parts[n->first_part + k])] = 1;
        }
    }
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* n = &d->nodes[i];
        uint8_t touches = 0;
        for (uint32_t k = 0; k < n->edge_count; ++k) {
            touches |= v->marks[d->edges[n->first_edge + k].node] & TOUCHES;
        }
        for (uint32_t k = 0; k < n->part_count; ++k) {
            touches |= v->has_parts[part_number(s, d->parts[n->first_part + k])] ? TOUCHES : 0;
        }
        v->marks[i] |= touches;
    }
    return STP_OK;
}

/// Whether the object contains the part.
static bool is_placed(setting* s, const stp_instance* what)
{
    stp_instance_search search = {.directory = s->v->directory, .visits_left = s->visits};
    bool found = stp_instance_holds(&search, s->placed->node, &s->placed->transform, what);
    s->visits = search.visits_left;
    if (search.gave_up && s->result == STP_OK) {
        s->result = stp_fail(s->v->context, STP_ERROR_LIMIT,
                             "visibility: the graph has too many nodes at the object's position");
    }
    return found;
}

static bool overlap(const stp_boxd* a, const stp_boxd* b)
{
    double margin = 1e-11 * fmax(fmax(fabs(b->max.x), fabs(b->max.y)), fabs(b->max.z));
    return a->min.x <= b->max.x + margin && b->min.x <= a->max.x + margin &&
           a->min.y <= b->max.y + margin && b->min.y <= a->max.y + margin &&
           a->min.z <= b->max.z + margin && b->min.z <= a->max.z + margin;
}

/// Stores the new state of a slot of a node. Makes the node's state mixed if it was not.
static void set_slot(setting* s, uint32_t node, uint32_t slot, uint32_t shown, uint32_t* state)
{
    if (stp_show_of(*state) != STP_SHOW_MIXED) {
        stp_result result = stp_visibility_split(s->v, node, *state, state);
        if (result != STP_OK) {
            s->result = result;
            stp_visibility_merge(s->v, shown);
            return;
        }
    }
    assert(slot < s->v->mixed[*state - STP_SHOW_MIXED].count);
    s->v->mixed[*state - STP_SHOW_MIXED].slots[slot] = shown;
}

static uint32_t state_below(const setting* s, uint32_t state, uint32_t slot)
{
    return stp_show_of(state) == STP_SHOW_MIXED ? stp_visibility_below(s->v, state, slot) : state;
}

/// Collapses the state of a node whose slots are all equal; otherwise returns it unchanged.
static uint32_t simplify(setting* s, uint32_t state)
{
    if (stp_show_of(state) != STP_SHOW_MIXED) {
        return state;
    }
    const stp_visibility_mixed* m = &s->v->mixed[state - STP_SHOW_MIXED];
    assert(m->count > 0);
    uint32_t first = m->slots[0];
    for (uint32_t i = 0; i < m->count; ++i) {
        if (m->slots[i] != first || stp_show_of(first) == STP_SHOW_MIXED) {
            return state;
        }
    }
    stp_visibility_merge(s->v, state);
    return first;
}

/// @return the state of a node at a place after the object was set
static uint32_t set_below(setting* s, uint32_t node, const stp_affine* transform, uint32_t state,
                          uint32_t depth)
{
    stp_visibility* v = s->v;
    const stp_store_directory* d = v->directory;
    const stp_store_node* n = &d->nodes[node];
    stp_boxd box = stp_affine_box(transform, n->bounds);
    if (s->result != STP_OK || state == s->show || (v->marks[node] & TOUCHES) == 0 ||
        !overlap(&box, &s->bounds)) {
        return state;
    }
    if (depth >= STP_INSTANCE_DEPTH || s->visits == 0) {
        s->result = stp_fail(v->context, STP_ERROR_LIMIT,
                             "visibility: the graph has too many nodes at the object's position");
        return state;
    }
    s->visits -= 1;
    if ((v->marks[node] & OF_PLACED) != 0) {
        stp_instance what = stp_instance_of_node(v->store, node, transform);
        if (is_placed(s, &what)) {
            stp_visibility_merge(v, state);
            return s->show;
        }
    }
    for (uint32_t i = 0; i < n->edge_count && s->result == STP_OK; ++i) {
        const stp_store_edge* edge = &d->edges[n->first_edge + i];
        stp_affine below = stp_affine_multiply(*transform, edge->transform);
        uint32_t before = state_below(s, state, i);
        uint32_t after = set_below(s, edge->node, &below, before, depth + 1);
        if (after != before) {
            set_slot(s, node, i, after, &state);
        }
    }
    for (uint32_t i = 0; i < n->part_count && s->result == STP_OK; ++i) {
        stp_store_part part = d->parts[n->first_part + i];
        uint32_t slot = n->edge_count + i;
        stp_instance what = stp_instance_of_part(v->store, part, transform);
        if (v->has_parts[part_number(s, part)] != 0 && state_below(s, state, slot) != s->show &&
            is_placed(s, &what)) {
            set_slot(s, node, slot, s->show, &state);
        }
    }
    return s->result == STP_OK ? simplify(s, state) : state;
}

stp_result stp_visibility_set(stp_visibility* v, const stp_placed_node* placed, stp_show show)
{
    const stp_store_directory* d = v->directory;
    if (placed->node >= d->node_count || d->root == STP_STORE_NONE || show > STP_SHOW_NOT) {
        return STP_OK;
    }
    setting s = {.v = v,
                 .placed = placed,
                 .bounds = stp_affine_box(&placed->transform, d->nodes[placed->node].bounds),
                 .show = (uint32_t)show,
                 .visits = visit_limit + UINT64_C(16) * ((uint64_t)d->node_count + d->edge_count +
                                                         d->part_count)};
    s.result = mark_nodes(&s);
    if (s.result == STP_OK) {
        stp_affine identity = stp_affine_identity();
        v->root = set_below(&s, d->root, &identity, v->root, 0);
        v->version += 1;
    }
    return s.result;
}
