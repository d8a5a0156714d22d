// SPDX-License-Identifier: MIT
// What is known of a store's nodes whatever the view: what moves, and how far things stick out of their boxes.
#include "select/select_internal.h"

static double above(double x, double most)
{
    return x > most ? x : most;
}

/// How far a box sticks out of another one, along any direction.
static double sticks_out(stp_box box, stp_boxd of)
{
    stp_vec3d low = stp_to_double(box.min), high = stp_to_double(box.max);
    double most = above(above(of.min.x - low.x, high.x - of.max.x), 0.0);
    most = above(above(of.min.y - low.y, high.y - of.max.y), most);
    most = above(above(of.min.z - low.z, high.z - of.max.z), most);
    return most * 1.7320508075688773; // the diagonal of a cube
}

static double find_margin(const stp_selection* s, const stp_select_graph* graph,
                          const stp_store_node* node)
{
    double margin = 0.0;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = s->directory->parts[node->first_part + i];
        stp_box box = part.kind == STP_STORE_PART_MESH
                          ? stp_store_describe_mesh(s->store, part.index)->bounds
                          : stp_store_describe_point_set(s->store, part.index)->bounds;
        margin = above(sticks_out(box, node->bounds), margin);
    }
    if (node->surfels != STP_STORE_NONE) { // positions are rounded
        const stp_surfels* surfels = stp_store_describe_surfels(s->store, node->surfels);
        double radius = (double)surfels->candidate_radius + (double)surfels->step;
        if (node->triangle_count == 0 && surfels->count > 0) { // points are never opened
            radius += (double)surfels->table.radius[surfels->table.size - 1];
        }
        margin = above(radius, margin);
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_store_edge* edge = &s->directory->edges[node->first_edge + i];
        double below = (double)graph->margins[edge->node];
        margin = above(below * stp_affine_scale(&edge->transform), margin);
    }
    return margin * (1.0 + 1e-6);
}

static void look_at_nodes(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* directory = s->directory;
    for (uint32_t i = 0; i < directory->node_count; ++i) {
        const stp_store_node* node = &directory->nodes[i];
        uint8_t bits = (node->flags & 1u) != 0 ? STP_NODE_MOVES : 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = directory->edges[node->first_edge + k].node;
            bits = graph->moving[child] != 0 ? bits | STP_MOVES_BELOW : bits;
        }
        graph->moving[i] = bits;
        graph->margins[i] = (float)find_margin(s, graph, node);
    }
}

stp_result stp_select_find_graph(stp_selection* s)
{
    const stp_store_directory* directory = s->directory;
    stp_select_graph* graph = s->list->graph;
    if (graph != NULL && graph->directory == directory && graph->nodes == directory->nodes &&
        graph->node_count == directory->node_count && graph->edge_count == directory->edge_count &&
        graph->surfels_count == directory->surfels_count) {
        s->graph = graph;
        return STP_OK;
    }
    stp_select_destroy_graph(s->context, graph);
    s->list->graph = graph = STP_NEW_ZEROED(s->context, stp_select_graph, 1);
    if (graph == NULL) {
        return stp_fail_memory(s->context);
    }
    graph->moving = STP_NEW_ARRAY(s->context, uint8_t, (size_t)directory->node_count + 1);
    graph->margins = STP_NEW_ARRAY(s->context, float, (size_t)directory->node_count + 1);
    if (graph->moving == NULL || graph->margins == NULL) {
        return stp_fail_memory(s->context); // not found by the next call, which makes it anew
    }
    look_at_nodes(s, graph);
    graph->directory = directory;
    graph->nodes = directory->nodes;
    graph->node_count = directory->node_count;
    graph->edge_count = directory->edge_count;
    graph->surfels_count = directory->surfels_count;
    s->graph = graph;
    return STP_OK;
}

void stp_select_destroy_graph(stp_context* context, stp_select_graph* graph)
{
    if (graph != NULL) {
        stp_free(context, graph->moving);
        stp_free(context, graph->margins);
        stp_free(context, graph);
    }
}
