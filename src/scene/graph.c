// SPDX-License-Identifier: MIT
#include "scene/graph.h"

#include "scene/finish_steps.h"

#include <assert.h>

stp_result stp_graph_add_edge(stp_graph* graph, uint32_t node, const stp_affine* transform)
{
    stp_scene* scene = graph->scene;
    assert(node < scene->node_count && "children are made first");
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->edges, graph->edge_capacity,
                                            scene->edge_count + 1);
    if (result != STP_OK) {
        return result;
    }
    scene->edges[scene->edge_count++] = (stp_edge){.node = node, .transform = *transform};
    return STP_OK;
}

stp_result stp_graph_add_part(stp_graph* graph, stp_part part)
{
    stp_scene* scene = graph->scene;
    assert(part.index < (part.kind == STP_PART_MESH ? scene->mesh_count : scene->point_set_count));
    stp_result result = STP_SCENE_MAKE_ROOM(scene->context, scene->node_parts, graph->part_capacity,
                                            scene->node_part_count + 1);
    if (result != STP_OK) {
        return result;
    }
    scene->node_parts[scene->node_part_count++] = part;
    return STP_OK;
}

stp_result stp_graph_close_node(stp_graph* graph, size_t first_edge, size_t first_part,
                                uint32_t flags, uint32_t* index)
{
    stp_scene* scene = graph->scene;
    assert(first_edge <= scene->edge_count && first_part <= scene->node_part_count);
    stp_node node = {
        .first_edge = (uint32_t)first_edge,
        .edge_count = (uint32_t)(scene->edge_count - first_edge),
        .first_part = (uint32_t)first_part,
        .part_count = (uint32_t)(scene->node_part_count - first_part),
        .flags = flags,
    };
    node.content = stp_node_hash(scene, &node);
    uint32_t found;
    stp_result result = stp_content_table_find(scene->context, &graph->table, node.content,
                                               (uint32_t)scene->node_count, &found);
    if (result != STP_OK) {
        return result;
    }
    assert(found <= scene->node_count);
    *index = found;
    if (found != scene->node_count) {
        scene->edge_count = first_edge;
        scene->node_part_count = first_part;
        return STP_OK;
    }
    result = STP_SCENE_MAKE_ROOM(scene->context, scene->nodes, graph->node_capacity,
                                 scene->node_count + 1);
    if (result != STP_OK) {
        return result;
    }
    stp_node_measure(scene, &node);
    scene->nodes[scene->node_count++] = node;
    return STP_OK;
}

void stp_graph_destroy(stp_graph* graph)
{
    stp_content_table_destroy(graph->scene->context, &graph->table);
}
