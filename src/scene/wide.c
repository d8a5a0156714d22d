// SPDX-License-Identifier: MIT
#include "scene/wide.h"

#include <string.h>

#define WIDTH 0.75 // of the parent's extent along each axis that counts
#define THIN                                                                                       \
    (1.0 / 16.)       // an axis counts where the parent's extent is more than this of its largest
#define MOST_NESTED 8 // dissolved below dissolved: what is below is looked at once for each

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

// Marks the chain of single nodes below the root, with the node of several things at its end. Where the chain moves
// nothing, that node simply becomes the root.
static void mark_root_chain(const stp_scene* scene, uint8_t* found)
{
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
        at = scene->edges[scene->nodes[at].first_edge].node;
        found[at] = STP_DISSOLVED_IN_ROOT;
    }
}

stp_result stp_find_wide(const stp_scene* scene, uint8_t** wide)
{
    stp_context* context = scene->context;
    uint8_t* found = STP_NEW_ZEROED(context, uint8_t, scene->node_count);
    uint8_t* uses = STP_NEW_ZEROED(context, uint8_t, scene->node_count);   // 2: more than one
    uint8_t* nested = STP_NEW_ZEROED(context, uint8_t, scene->node_count); // dissolved levels below
    if (found == NULL || uses == NULL || nested == NULL) {
        stp_free(context, found);
        stp_free(context, uses);
        stp_free(context, nested);
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < scene->edge_count; ++i) {
        uint8_t* count = &uses[scene->edges[i].node];
        *count = *count < 2 ? (uint8_t)(*count + 1) : 2;
    }
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        bool opens = count_items(node) > 1 && node->flags == 0;
        for (uint32_t k = 0; opens && k < node->edge_count; ++k) {
            const stp_edge* edge = &scene->edges[node->first_edge + k];
            const stp_node* child = &scene->nodes[edge->node];
            if (uses[edge->node] == 1 && child->flags == 0 && count_items(child) > 1 &&
                nested[edge->node] < MOST_NESTED &&
                is_as_wide(stp_affine_box(&edge->transform, child->bounds), node->bounds)) {
                found[edge->node] = STP_DISSOLVED;
                uint8_t depth = (uint8_t)(nested[edge->node] + 1);
                nested[i] = depth > nested[i] ? depth : nested[i];
            }
        }
    }
    mark_root_chain(scene, found);
    stp_free(context, nested);
    stp_free(context, uses);
    *wide = found;
    return STP_OK;
}
