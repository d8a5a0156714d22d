// SPDX-License-Identifier: MIT
// The graph of nodes in the making. Children are made before parents; equal content is one node.
#pragma once

#include "scene/scene.h"

/// Fills scene->nodes, edges and node_parts, which are empty at first. All else is zero at first.
typedef struct stp_graph {
    stp_scene* scene;
    stp_content_table table;
    size_t edge_capacity, part_capacity, node_capacity;
} stp_graph;

// All return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged).
STP_MUST_USE stp_result stp_graph_add_edge(stp_graph* graph, uint32_t node,
                                           const stp_affine* transform);
STP_MUST_USE stp_result stp_graph_add_part(stp_graph* graph, stp_part part);

/// Makes a node of the edges and parts from `first_edge` and `first_part` to the ends of their arrays, measured
/// and with its content; or finds one with that content and takes them back.
STP_MUST_USE stp_result stp_graph_close_node(stp_graph* graph, size_t first_edge, size_t first_part,
                                             uint32_t flags, uint32_t* index);
void stp_graph_destroy(stp_graph* graph);
