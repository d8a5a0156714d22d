// SPDX-License-Identifier: MIT
// Builder of the node graph. Children are made before parents; equal content becomes one node.
#pragma once

#include "scene/scene.h"

/// Fills scene->nodes, edges and node_parts, which must be empty. Initialise the rest to zero.
typedef struct stp_graph {
    stp_scene* scene;
    stp_content_table table;
    size_t edge_capacity, part_capacity, node_capacity;
} stp_graph;

// All return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged).
STP_MUST_USE stp_result stp_graph_add_edge(stp_graph* graph, uint32_t node,
                                           const stp_affine* transform);
STP_MUST_USE stp_result stp_graph_add_part(stp_graph* graph, stp_part part);

/// Makes a node of the edges and parts from `first_edge` and `first_part` on, with its bounds,
/// counts and content. If a node with that content exists, returns it and removes the edges and
/// parts.
STP_MUST_USE stp_result stp_graph_close_node(stp_graph* graph, size_t first_edge, size_t first_part,
                                             uint32_t flags, uint32_t* index);
void stp_graph_destroy(stp_graph* graph);
