// SPDX-License-Identifier: MIT
#include "scene/graph.h"

#include "scene/content_hash.h"
#include "scene/mesh_area.h"

#include <assert.h>

// Room for one more element; NULL if out of memory or indices.
static void* grow(stp_graph* graph, void* array, size_t* capacity, size_t count, size_t size)
{
    return count < STP_NONE
               ? stp_grow_array(graph->scene->context, array, capacity, count + 1, size)
               : NULL;
}

stp_result stp_graph_add_edge(stp_graph* graph, uint32_t node, const stp_affine* transform)
{
    stp_scene* scene = graph->scene;
    assert(node < scene->node_count && "children are made first");
    stp_edge* edges =
        grow(graph, scene->edges, &graph->edge_capacity, scene->edge_count, sizeof(*edges));
    if (edges == NULL) {
        return stp_fail_memory(scene->context);
    }
    scene->edges = edges;
    edges[scene->edge_count++] = (stp_edge){.node = node, .transform = *transform};
    return STP_OK;
}

stp_result stp_graph_add_part(stp_graph* graph, stp_part part)
{
    stp_scene* scene = graph->scene;
    assert(part.index < (part.kind == STP_PART_MESH ? scene->mesh_count : scene->point_set_count));
    stp_part* parts = grow(graph, scene->node_parts, &graph->part_capacity, scene->node_part_count,
                           sizeof(*parts));
    if (parts == NULL) {
        return stp_fail_memory(scene->context);
    }
    scene->node_parts = parts;
    parts[scene->node_part_count++] = part;
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
    stp_node* nodes =
        grow(graph, scene->nodes, &graph->node_capacity, scene->node_count, sizeof(*nodes));
    if (nodes == NULL) {
        return stp_fail_memory(scene->context);
    }
    scene->nodes = nodes;
    stp_node_measure(scene, &node);
    nodes[scene->node_count++] = node;
    return STP_OK;
}

void stp_graph_destroy(stp_graph* graph)
{
    stp_content_table_destroy(graph->scene->context, &graph->table);
}
