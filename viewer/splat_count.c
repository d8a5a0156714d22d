// SPDX-License-Identifier: MIT
#include "splat_count.h"

#include <stipple/surfels.h>

#include <stdlib.h>

/// Splats of a node and below.
typedef struct node_splats {
    uint32_t all;    ///< none of its ancestors is drawn by a set
    uint32_t moving; ///< one is: only what moves is drawn
} node_splats;

static uint32_t add(uint32_t a, uint32_t b)
{
    return a > SPLAT_COUNT_MOST - b ? SPLAT_COUNT_MOST : a + b;
}

/// How many splats of its set a node is drawn with, at the most.
static uint32_t splats_of_node(const stp_store* store, const stp_store_directory* d,
                               uint32_t method, uint32_t node)
{
    uint32_t set = stp_store_set_of(d, method, node);
    uint32_t count = set != STP_STORE_NONE ? stp_store_describe_surfels(store, set)->count : 0;
    // a set of merges holds one splat and two for each split, which replace another
    count = d->methods[method].id == STP_METHOD_PSP ? count / 2 + count % 2 : count;
    return count < SPLAT_COUNT_MOST ? count : SPLAT_COUNT_MOST;
}

uint32_t splat_count_of_scene(const stp_store* store, uint32_t method)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    if (d->root == STP_STORE_NONE || method >= d->method_count || d->surfels_count == 0) {
        return 0;
    }
    node_splats* nodes = calloc(d->node_count, sizeof(*nodes));
    if (nodes == NULL) {
        return 0;
    }
    for (uint32_t i = 0; i < d->node_count; ++i) { // children come first
        const stp_store_node* node = &d->nodes[i];
        uint32_t own = splats_of_node(store, d, method, i), below = 0, moving = 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const node_splats* child = &nodes[d->edges[node->first_edge + k].node];
            below = add(below, child->all);
            moving = add(moving, child->moving);
        }
        bool moves = (node->flags & 1u) != 0;
        nodes[i].all = own > 0 ? add(own, moving) : below;
        nodes[i].moving = moves ? nodes[i].all : moving;
    }
    uint32_t all = nodes[d->root].all;
    free(nodes);
    return all;
}

uint32_t splat_count_within(uint64_t count, uint32_t all)
{
    count = count < SPLAT_COUNT_LEAST ? SPLAT_COUNT_LEAST : count;
    return count < all ? (uint32_t)count : all;
}

uint32_t splat_count_step(uint32_t count, uint32_t all, bool up, bool fine)
{
    uint64_t from = splat_count_within(count, all);
    uint64_t step = fine ? from / 20 : up ? from : from - from / 2;
    step = step > 0 ? step : 1;
    return splat_count_within(up ? from + step : from - step, all);
}
