// SPDX-License-Identifier: MIT
// View-independent properties of a store's nodes: which ones move, how far content extends beyond
// boxes, and the smallest radius for which a node's own splats are used.
#include "base/splats/prefix_table.h"
#include "select/select_internal.h"

#include <assert.h>

/// Upper bound on the overhang of a box beyond another, in any direction.
static double max_overhang(stp_box box, stp_boxd of)
{
    stp_vec3d low = stp_to_double(box.min), high = stp_to_double(box.max);
    double maximum = stp_maxd(stp_maxd(of.min.x - low.x, high.x - of.max.x), 0.0);
    maximum = stp_maxd(stp_maxd(of.min.y - low.y, high.y - of.max.y), maximum);
    maximum = stp_maxd(stp_maxd(of.min.z - low.z, high.z - of.max.z), maximum);
    return maximum * 1.7320508075688773; // of the axes' maximum, to the diagonal of a cube
}

static double find_margin(const stp_selection* s, const stp_select_graph* graph, uint32_t index)
{
    const stp_store_node* node = &s->directory->nodes[index];
    uint32_t set = stp_select_set_of(s, index);
    double margin = 0.0;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = s->directory->parts[node->first_part + i];
        stp_box box = part.kind == STP_STORE_PART_MESH
                          ? stp_store_describe_mesh(s->store, part.index)->bounds
                          : stp_store_describe_point_set(s->store, part.index)->bounds;
        margin = stp_maxd(max_overhang(box, node->bounds), margin);
    }
    const uint32_t* levels = s->directory->level_starts;
    for (uint32_t i = levels != NULL ? levels[index] : 0; levels != NULL && i < levels[index + 1];
         ++i) { // their vertices have moved
        const stp_store_mesh* mesh =
            stp_store_describe_mesh(s->store, s->directory->levels[i].mesh);
        margin = stp_maxd(max_overhang(mesh->bounds, node->bounds), margin);
    }
    if (set != STP_STORE_NONE) { // positions are rounded
        const stp_splats* splats = stp_store_describe_splat_set(s->store, set);
        double radius = (double)splats->candidate_radius + (double)splats->step;
        if (node->triangle_count == 0 && splats->count > 0) { // points are never opened
            radius += (double)splats->table.radius[splats->table.size - 1];
            radius +=
                (double)splats->candidate_radius *
                (double)stp_largest_growth(s->directory->shadings, s->directory->shading_count);
        }
        margin = stp_maxd(radius, margin);
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        const stp_store_edge* edge = &s->directory->edges[node->first_edge + i];
        double below = (double)graph->margins[edge->node];
        margin = stp_maxd(below * stp_affine_scale(&edge->transform), margin);
    }
    assert(!(margin < 0.0));
    return margin * (1.0 + 1e-6);
}

static double coverage_radius(const stp_splats* splats)
{
    // surface may lie this far from a candidate, regardless of how many are drawn
    return stp_maxd((double)stp_prefix_table_radius(&splats->table, splats->count),
                    (double)splats->candidate_radius);
}

/// Factor by which a node is opened earlier than its radius requires. From one splat per
/// STP_TRIANGLES_PER_SPLAT triangles on, triangles look better for their cost, so larger sets are
/// used only up to that ratio.
static double find_early_switch(const stp_store_node* node, const stp_splats* splats)
{
    double triangles = (double)node->triangle_count;
    if (!(triangles > 0.0)) {
        return 1.0;
    }
    double factor = sqrt(STP_TRIANGLES_PER_SPLAT * (double)splats->count / triangles);
    return fmin(fmax(factor, 1.0), STP_EARLY_SWITCH_MAX);
}

/// Upper bound of the work of triangles and sets drawn when a node is opened; children come first.
/// Excludes moving nodes, which are always drawn, and original points, which appear all at once
/// (traverse.c).
static double find_work(const stp_selection* s, const stp_select_graph* graph,
                        const stp_store_node* node)
{
    double work = 0.0;
    for (uint32_t i = 0; i < node->part_count; ++i) {
        stp_store_part part = s->directory->parts[node->first_part + i];
        bool mesh = part.kind == STP_STORE_PART_MESH;
        work += mesh ? (double)stp_store_describe_mesh(s->store, part.index)->triangle_count : 0.0;
    }
    for (uint32_t i = 0; i < node->edge_count; ++i) {
        uint32_t child = s->directory->edges[node->first_edge + i].node;
        uint32_t set = stp_select_set_of(s, child);
        double own =
            set != STP_STORE_NONE
                ? STP_SPLAT_WORK * (double)stp_store_describe_splat_set(s->store, set)->count
                : 0.0;
        bool rests = (graph->moving[child] & STP_NODE_MOVES) == 0;
        work += rests ? stp_maxd((double)graph->works[child], own) : 0.0;
    }
    return work;
}

static void analyze_nodes(const stp_selection* s, stp_select_graph* graph)
{
    const stp_store_directory* directory = s->directory;
    for (uint32_t i = 0; i < directory->node_count; ++i) {
        const stp_store_node* node = &directory->nodes[i];
        uint8_t bits = (node->flags & 1u) != 0 ? STP_NODE_MOVES : 0;
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = directory->edges[node->first_edge + k].node;
            assert(child < i && "children come before their parents");
            bits = graph->moving[child] != 0 ? bits | STP_MOVES_BELOW : bits;
            graph->has_sets[i] = graph->has_sets[i] || graph->has_sets[child];
        }
        graph->moving[i] = bits;
        graph->margins[i] = (float)find_margin(s, graph, i);
        uint32_t set = stp_select_set_of(s, i);
        const stp_splats* splats =
            set != STP_STORE_NONE ? stp_store_describe_splat_set(s->store, set) : NULL;
        graph->has_sets[i] = graph->has_sets[i] || splats != NULL;
        graph->reaches[i] = splats != NULL ? coverage_radius(splats) : 0.0;
        graph->early_switches[i] = splats != NULL ? (float)find_early_switch(node, splats) : 1.0f;
        graph->works[i] = (float)fmin(find_work(s, graph, node), (double)FLT_MAX);
    }
}

// Marks parts that a node lists again. `last` has an entry per mesh and point set: 1 + the last
// node that listed it.
static void find_repeated(const stp_store_directory* d, uint32_t* last, uint8_t* repeated)
{
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* node = &d->nodes[i];
        for (uint32_t k = node->first_part; k - node->first_part < node->part_count; ++k) {
            const stp_store_part* part = &d->parts[k];
            uint32_t resource =
                part->index + (part->kind == STP_STORE_PART_MESH ? 0 : d->mesh_count);
            assert(last[resource] <= i + 1 && "nodes are visited in order");
            repeated[k / 8] |= (uint8_t)((last[resource] == i + 1 ? 1u : 0u) << k % 8);
            last[resource] = i + 1;
        }
    }
}

stp_result stp_select_find_graph(stp_selection* s)
{
    const stp_store_directory* directory = s->directory;
    stp_select_graph* graph = s->list->graph;
    if (graph != NULL && graph->directory == directory && graph->nodes == directory->nodes &&
        graph->node_count == directory->node_count && graph->edge_count == directory->edge_count &&
        graph->part_count == directory->part_count && graph->set_count == directory->set_count &&
        graph->method == s->method) {
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
    graph->reaches = STP_NEW_ARRAY(s->context, double, (size_t)directory->node_count + 1);
    graph->early_switches = STP_NEW_ARRAY(s->context, float, (size_t)directory->node_count + 1);
    graph->works = STP_NEW_ARRAY(s->context, float, (size_t)directory->node_count + 1);
    graph->repeated = STP_NEW_ZEROED(s->context, uint8_t, (size_t)directory->part_count / 8 + 1);
    graph->has_sets = STP_NEW_ZEROED(s->context, bool, (size_t)directory->node_count + 1);
    graph->maximum = STP_NEW_ZEROED(s->context, uint32_t, (size_t)directory->node_count + 1);
    graph->level_floors = STP_NEW_ARRAY(s->context, float, (size_t)directory->node_count + 1);
    graph->others = STP_NEW_ZEROED(s->context, bool, (size_t)directory->node_count + 1);
    graph->opens_below = STP_NEW_ARRAY(s->context, float, 2 * (size_t)directory->node_count + 1);
    graph->level_overhangs = STP_NEW_ARRAY(s->context, float, (size_t)directory->node_count + 1);
    graph->level_rows = STP_NEW_ARRAY(s->context, uint32_t, (size_t)directory->node_count + 1);
    uint32_t* last = STP_NEW_ZEROED(s->context, uint32_t,
                                    (size_t)directory->mesh_count + directory->point_set_count + 1);
    if (graph->moving == NULL || graph->margins == NULL || graph->reaches == NULL ||
        graph->early_switches == NULL || graph->works == NULL || graph->repeated == NULL ||
        graph->has_sets == NULL || graph->maximum == NULL || graph->level_floors == NULL ||
        graph->level_overhangs == NULL || graph->others == NULL || graph->opens_below == NULL ||
        graph->level_rows == NULL || last == NULL) {
        stp_free(s->context, last);
        return stp_fail_memory(s->context); // the next call does not find it, and rebuilds it
    }
    analyze_nodes(s, graph);
    find_repeated(directory, last, graph->repeated);
    stp_select_find_levels(s, graph);
    stp_free(s->context, last);
    stp_result result = stp_select_count_levels(s, graph);
    result = result == STP_OK ? stp_select_find_level_works(s, graph) : result;
    if (result != STP_OK) {
        return result;
    }
    graph->directory = directory;
    graph->nodes = directory->nodes;
    graph->node_count = directory->node_count;
    graph->edge_count = directory->edge_count;
    graph->part_count = directory->part_count;
    graph->set_count = directory->set_count;
    graph->method = s->method;
    s->graph = graph;
    return STP_OK;
}

void stp_select_destroy_graph(stp_context* context, stp_select_graph* graph)
{
    if (graph != NULL) {
        stp_free(context, graph->moving);
        stp_free(context, graph->margins);
        stp_free(context, graph->reaches);
        stp_free(context, graph->early_switches);
        stp_free(context, graph->works);
        stp_free(context, graph->repeated);
        stp_free(context, graph->has_sets);
        stp_free(context, graph->maximum);
        stp_free(context, graph->level_floors);
        stp_free(context, graph->others);
        stp_free(context, graph->opens_below);
        stp_free(context, graph->level_overhangs);
        stp_free(context, graph->level_rows);
        stp_free(context, graph->level_counts);
        stp_free(context, graph->level_areas);
        stp_free(context, graph);
    }
}
