// SPDX-License-Identifier: MIT
#include "program/drawing/scene_farthest.h"

#include <assert.h>

static stp_boxd widen(stp_box box)
{
    return (stp_boxd){stp_to_double(box.min), stp_to_double(box.max)};
}

static uint32_t count_children(const void* user, const stp_farthest_item* node)
{
    const stp_scene* scene = user;
    const stp_node* n = &scene->nodes[node->index];
    return n->edge_count + n->part_count;
}

static bool get_child(const void* user, const stp_farthest_item* node, uint32_t i,
                      stp_farthest_item* child)
{
    const stp_scene* scene = user;
    const stp_node* n = &scene->nodes[node->index];
    if (i < n->edge_count) {
        const stp_edge* edge = &scene->edges[n->first_edge + i];
        *child =
            (stp_farthest_item){.index = edge->node,
                                .transform = stp_affine_multiply(node->transform, edge->transform),
                                .bounds = scene->nodes[edge->node].bounds};
        return true;
    }
    stp_part part = scene->node_parts[n->first_part + i - n->edge_count];
    *child = (stp_farthest_item){.is_part = true,
                                 .kind = part.kind,
                                 .index = part.index,
                                 .transform = node->transform,
                                 .bounds = widen(part.kind == STP_PART_MESH
                                                     ? scene->meshes[part.index].bounds
                                                     : scene->point_sets[part.index].bounds)};
    return true;
}

static bool measure_part(const void* user, const stp_farthest_item* part, stp_vec3d direction,
                         stp_vec3d* point)
{
    const stp_scene* scene = user;
    double farthest = -HUGE_VAL;
    assert(part->is_part);
    if (part->kind == STP_PART_MESH) {
        const stp_mesh* mesh = &scene->meshes[part->index];
        stp_farthest_vertex(mesh->positions, mesh->vertex_count, direction, &farthest, point);
    } else {
        const stp_point_set* points = &scene->point_sets[part->index];
        stp_farthest_vertex(points->positions, points->point_count, direction, &farthest, point);
    }
    return farthest > -HUGE_VAL;
}

stp_farthest_graph scene_farthest_graph(const stp_scene* scene)
{
    assert(scene->root != STP_NONE);
    return (stp_farthest_graph){.user = scene,
                                .root = {.index = scene->root,
                                         .transform = stp_affine_identity(),
                                         .bounds = scene->nodes[scene->root].bounds},
                                .count = count_children,
                                .get = get_child,
                                .measure = measure_part};
}
