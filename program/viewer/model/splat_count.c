// SPDX-License-Identifier: MIT
#include "program/viewer/model/splat_count.h"

#include "select/select.h"

#include <stdlib.h>

/// Splats of a subtree.
typedef struct node_splats {
    uint32_t all;    ///< if no ancestor is drawn by a set
    uint32_t moving; ///< if an ancestor is: only moving parts are drawn
    bool needs_all, needs_moving;
} node_splats;

static uint32_t add(uint32_t a, uint32_t b)
{
    return a > SPLAT_COUNT_MAX - b ? SPLAT_COUNT_MAX : a + b;
}

/// Marks the sets that contribute to the root's count: sets of other nodes are not read.
static void mark_needed(const stp_store* store, uint32_t method, node_splats* nodes)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    nodes[d->root].needs_all = true;
    for (uint32_t i = d->node_count; i-- > 0;) { // parents come last
        const stp_store_node* node = &d->nodes[i];
        node_splats* n = &nodes[i];
        n->needs_all = n->needs_all || (n->needs_moving && (node->flags & 1u) != 0);
        uint32_t set = stp_store_set_of(d, method, i);
        bool has_set = set != STP_STORE_NONE && stp_store_describe_splat_set(store, set)->count > 0;
        bool all = n->needs_all && !has_set;
        bool moving = n->needs_moving || (n->needs_all && has_set);
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            node_splats* child = &nodes[d->edges[node->first_edge + k].node];
            child->needs_all = child->needs_all || all;
            child->needs_moving = child->needs_moving || moving;
        }
    }
}

/// The maximum number of splats of its set that a node draws.
static stp_result splats_of_node(stp_store* store, uint32_t method, uint32_t node, uint32_t* count)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    uint32_t set = stp_store_set_of(d, method, node);
    *count = set != STP_STORE_NONE ? stp_store_describe_splat_set(store, set)->count : 0;
    stp_result result = STP_OK;
    if (*count > 0 && d->methods[method].id == STP_METHOD_PSP) {
        bool ends = false;
        result = stp_select_count_states(store, set, count, &ends);
    }
    *count = *count < SPLAT_COUNT_MAX ? *count : SPLAT_COUNT_MAX;
    return result;
}

uint32_t splat_count_of_scene(stp_store* store, uint32_t method)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    if (d->root == STP_STORE_NONE || method >= d->method_count || d->set_count == 0) {
        return 0;
    }
    node_splats* nodes = calloc(d->node_count, sizeof(*nodes));
    if (nodes == NULL) {
        return 0;
    }
    mark_needed(store, method, nodes);
    stp_result result = STP_OK;
    for (uint32_t i = 0; i < d->node_count && result == STP_OK; ++i) { // children come first
        const stp_store_node* node = &d->nodes[i];
        uint32_t own = 0, below = 0, moving = 0;
        if (nodes[i].needs_all) {
            result = splats_of_node(store, method, i, &own);
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const node_splats* child = &nodes[d->edges[node->first_edge + k].node];
            below = add(below, child->all);
            moving = add(moving, child->moving);
        }
        bool moves = (node->flags & 1u) != 0;
        nodes[i].all = own > 0 ? add(own, moving) : below;
        nodes[i].moving = moves ? nodes[i].all : moving;
    }
    uint32_t all = result == STP_OK ? nodes[d->root].all : 0;
    free(nodes);
    return all;
}

uint32_t splat_count_within(uint64_t count, uint32_t all)
{
    count = count < SPLAT_COUNT_MIN ? SPLAT_COUNT_MIN : count;
    return count < all ? (uint32_t)count : all;
}

uint32_t splat_count_step(uint32_t count, uint32_t all, bool up, bool fine)
{
    uint64_t from = splat_count_within(count, all);
    uint64_t step = fine ? from / 20 : up ? from : from - from / 2;
    step = step > 0 ? step : 1;
    return splat_count_within(up ? from + step : from - step, all);
}
