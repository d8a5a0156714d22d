// SPDX-License-Identifier: MIT
#include "scene/scene.h"

#include <assert.h>

typedef struct visit {
    uint32_t node;
    stp_affine transform;
    uint32_t flags;
} visit;

typedef struct flatten {
    const stp_scene* scene;
    stp_placed_part* parts;
    size_t part_count, part_capacity, limit;
    visit* stack;
    size_t stack_count, stack_capacity;
} flatten;

static stp_result push(flatten* f, const visit* v)
{
    stp_context* context = f->scene->context;
    if (!STP_MAKE_ROOM(context, f->stack, f->stack_capacity, f->stack_count + 1)) {
        return stp_fail_memory(context);
    }
    f->stack[f->stack_count++] = *v;
    return STP_OK;
}

static stp_result place_parts(flatten* f, const visit* v)
{
    stp_context* context = f->scene->context;
    const stp_node* node = &f->scene->nodes[v->node];
    for (uint32_t i = 0; i < node->part_count; ++i) {
        if (f->part_count >= f->limit) {
            return stp_fail(context, STP_ERROR_LIMIT, "the scene has more than %zu placed parts",
                            f->limit);
        }
        if (!STP_MAKE_ROOM(context, f->parts, f->part_capacity, f->part_count + 1)) {
            return stp_fail_memory(context);
        }
        f->parts[f->part_count++] =
            (stp_placed_part){.part = f->scene->node_parts[node->first_part + i],
                              .transform = v->transform,
                              .flags = v->flags};
    }
    return STP_OK;
}

stp_result stp_scene_flatten(const stp_scene* scene, uint32_t node, size_t limit,
                             stp_placed_part** parts, size_t* part_count)
{
    flatten f = {.scene = scene, .limit = limit};
    stp_result result = STP_OK;
    if (node != STP_NONE) {
        result = push(&f, &(visit){.node = node, .transform = stp_affine_identity()});
    }
    while (result == STP_OK && f.stack_count > 0) {
        visit v = f.stack[--f.stack_count];
        assert(v.node < scene->node_count);
        result = place_parts(&f, &v);
        const stp_node* at = &scene->nodes[v.node];
        for (uint32_t i = at->edge_count; result == STP_OK && i > 0; --i) { // first child on top
            const stp_edge* edge = &scene->edges[at->first_edge + i - 1];
            result = push(&f, &(visit){
                                  .node = edge->node,
                                  .transform = stp_affine_multiply(v.transform, edge->transform),
                                  .flags = v.flags | scene->nodes[edge->node].flags,
                              });
        }
    }
    stp_free(scene->context, f.stack);
    if (result != STP_OK) {
        stp_free(scene->context, f.parts);
        return result;
    }
    assert(f.part_count <= limit);
    *parts = f.parts;
    *part_count = f.part_count;
    return STP_OK;
}
