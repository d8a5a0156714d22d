// SPDX-License-Identifier: MIT
#include "scene/partition_steps.h"

#include <assert.h>
#include <string.h>

#define WIDTH 0.75       // minimum share of the parent's extent along each relevant axis
#define THIN (1.0 / 16.) // relevant axes: minimum share of the parent's largest extent
#define MAX_NESTED 8     // limit on nested dissolving: content is visited once per level
// A child with this many times the items of the rest is nearly its parent, and stays whole.
#define MAX_ALONE 4

typedef struct search {
    const stp_scene* scene;
    uint8_t* found;      ///< by edge
    uint8_t* uses;       ///< by node: edges to it; 2: more than one
    uint8_t* nested;     ///< by node: dissolved levels below
    uint64_t* sizes;     ///< by node: its items, including those of dissolved children
    uint64_t repeatable; ///< remaining items that dissolving shared nodes may duplicate
} search;

static uint32_t count_items(const stp_node* node)
{
    return node->edge_count + node->part_count;
}

static bool is_as_wide(stp_boxd child, stp_boxd parent)
{
    stp_vec3d c = stp_subd(child.max, child.min), p = stp_subd(parent.max, parent.min);
    double child_sizes[3] = {c.x, c.y, c.z}, parent_sizes[3] = {p.x, p.y, p.z};
    double largest = p.x > p.y ? p.x : p.y;
    largest = p.z > largest ? p.z : largest;
    if (!(largest > 0.0)) {
        return false;
    }
    for (int k = 0; k < 3; ++k) {
        bool counts = parent_sizes[k] > THIN * largest;
        if (counts && !(child_sizes[k] >= WIDTH * parent_sizes[k])) {
            return false;
        }
    }
    return true;
}

// Whether a child may be dissolved, as far as parent and child alone tell.
static bool is_layer(const search* s, const stp_node* node, const stp_edge* edge)
{
    const stp_node* child = &s->scene->nodes[edge->node];
    return child->flags == 0 && count_items(child) > 1 && s->nested[edge->node] < MAX_NESTED &&
           is_as_wide(stp_affine_box(&edge->transform, child->bounds), node->bounds);
}

// Dissolving shared nodes duplicates items. @return false if the limit is exceeded
static bool may_repeat(search* s, uint32_t child)
{
    uint64_t repeated = s->uses[child] > 1 ? s->sizes[child] : 0;
    bool may = repeated <= s->repeatable;
    assert(child < s->scene->node_count && s->sizes[child] > 0);
    s->repeatable -= may ? repeated : 0;
    return may;
}

// Marks the layers of a node; its children must be done.
static void mark_layers(search* s, uint32_t index)
{
    const stp_node* node = &s->scene->nodes[index];
    const stp_edge* edges = &s->scene->edges[node->first_edge];
    uint8_t* found = &s->found[node->first_edge];
    uint64_t all = count_items(node); // if every layer were dissolved
    bool opens = all > 1 && node->flags == 0;
    for (uint32_t k = 0; opens && k < node->edge_count; ++k) {
        if (is_layer(s, node, &edges[k])) {
            found[k] = STP_DISSOLVED;
            all += s->sizes[edges[k].node] - 1;
        }
    }
    s->sizes[index] = count_items(node);
    for (uint32_t k = 0; k < node->edge_count; ++k) {
        uint32_t child = edges[k].node;
        uint64_t size = s->sizes[child];
        if (found[k] == STP_DISSOLVED &&
            (size > MAX_ALONE * (all - size) || !may_repeat(s, child))) {
            found[k] = 0;
        }
        if (found[k] == STP_DISSOLVED) {
            assert(child < index && "children before their parents");
            uint8_t depth = (uint8_t)(s->nested[child] + 1);
            s->nested[index] = depth > s->nested[index] ? depth : s->nested[index];
            s->sizes[index] += size - 1;
        }
    }
}

// Marks the chain of single nodes from the root down to the first node with several items, unless
// its transforms cancel out: then that node becomes the root anyway.
static void mark_root_chain(search* s)
{
    const stp_scene* scene = s->scene;
    stp_affine transform = stp_affine_identity();
    uint32_t end = scene->root;
    while (count_items(&scene->nodes[end]) == 1) {
        const stp_node* node = &scene->nodes[end];
        if (node->edge_count == 0 || node->flags != 0) {
            return;
        }
        const stp_edge* edge = &scene->edges[node->first_edge];
        transform = stp_affine_multiply(transform, edge->transform);
        end = edge->node;
    }
    if (stp_affine_is_identity(&transform) || scene->nodes[end].flags != 0) {
        return;
    }
    for (uint32_t at = scene->root; at != end;) {
        uint32_t edge = scene->nodes[at].first_edge;
        s->found[edge] = STP_DISSOLVED_IN_ROOT;
        at = scene->edges[edge].node;
    }
}

stp_result stp_find_dissolved(const stp_scene* scene, uint8_t** wide)
{
    stp_context* context = scene->context;
    search s = {.scene = scene,
                .found = STP_NEW_ZEROED(context, uint8_t, scene->edge_count),
                .uses = STP_NEW_ZEROED(context, uint8_t, scene->node_count),
                .nested = STP_NEW_ZEROED(context, uint8_t, scene->node_count),
                .sizes = STP_NEW_ARRAY(context, uint64_t, scene->node_count),
                .repeatable = (uint64_t)scene->edge_count + scene->node_part_count};
    bool made = s.found != NULL && s.uses != NULL && s.nested != NULL && s.sizes != NULL;
    for (size_t i = 0; made && i < scene->edge_count; ++i) {
        uint8_t* count = &s.uses[scene->edges[i].node];
        *count = *count < 2 ? (uint8_t)(*count + 1) : 2;
    }
    for (size_t i = 0; made && i < scene->node_count; ++i) { // children before their parents
        mark_layers(&s, (uint32_t)i);
    }
    if (made) {
        mark_root_chain(&s);
    } else {
        stp_free(context, s.found);
    }
    stp_free(context, s.sizes);
    stp_free(context, s.nested);
    stp_free(context, s.uses);
    *wide = made ? s.found : NULL;
    return made ? STP_OK : stp_fail_memory(context);
}
