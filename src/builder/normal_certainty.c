// SPDX-License-Identifier: MIT
//
// Normals of point sets that have none are estimated, and their sign is unknown. Normals of the
// input are known: they come from files, or importers turn normals of a scanner's grid towards the
// scanner. `stochastic` finds the signs of its own estimates. Sets with triangles below them are
// captured from outside, so their normals face outwards.
#include "builder/writer_input.h"

#include <assert.h>

typedef struct node_certainty {
    double scale; ///< largest scale at which the node is shown; 0: never
    bool unknown; ///< there are points without normals below it
} node_certainty;

// Children come before their parents.
static void find_unknown(const stp_scene* scene, node_certainty* nodes)
{
    for (size_t i = 0; i < scene->node_count; ++i) {
        const stp_node* node = &scene->nodes[i];
        for (uint32_t k = 0; k < node->part_count; ++k) {
            stp_part part = scene->node_parts[node->first_part + k];
            nodes[i].unknown = nodes[i].unknown || (part.kind == STP_PART_POINTS &&
                                                    scene->point_sets[part.index].normals == NULL);
        }
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            uint32_t child = scene->edges[node->first_edge + k].node;
            assert(child < i && "children come before their parents");
            nodes[i].unknown = nodes[i].unknown || nodes[child].unknown;
        }
    }
}

static void find_scales(const stp_scene* scene, node_certainty* nodes)
{
    if (scene->root != STP_NONE) {
        nodes[scene->root].scale = 1.0;
    }
    for (size_t i = scene->node_count; i-- > 0;) {
        const stp_node* node = &scene->nodes[i];
        for (uint32_t k = 0; k < node->edge_count; ++k) {
            const stp_edge* edge = &scene->edges[node->first_edge + k];
            double scale = nodes[i].scale * stp_affine_scale(&edge->transform);
            nodes[edge->node].scale = fmax(nodes[edge->node].scale, scale);
        }
    }
}

static bool has_unknown_signs(const stp_scene* scene, const node_certainty* nodes, size_t node)
{
    return nodes[node].unknown && scene->nodes[node].triangle_count == 0;
}

static void note_signs(const stp_scene* scene, const stp_store_directory* d,
                       const node_certainty* nodes, stp_splats* sets)
{
    for (uint32_t m = 0; m < d->method_count; ++m) {
        const stp_method* method = stp_method_by_id(d->methods[m].id);
        bool finds_signs = method != NULL && method->finds_signs;
        for (uint32_t i = 0; i < d->node_count; ++i) {
            uint32_t set = stp_store_set_of(d, m, i);
            if (set != STP_STORE_NONE) { // replaces the data of a previous output
                sets[set].position_error = 0.0f;
                sets[set].unknown_signs = !finds_signs && has_unknown_signs(scene, nodes, i);
            }
        }
    }
}

stp_result stp_build_note_signs(stp_context* context, const stp_scene* scene,
                                const uint32_t* set_of_node, stp_splats* sets)
{
    node_certainty* nodes = STP_NEW_ZEROED(context, node_certainty, scene->node_count + 1);
    if (nodes == NULL) {
        return stp_fail_memory(context);
    }
    find_unknown(scene, nodes);
    for (size_t i = 0; i < scene->node_count; ++i) {
        if (set_of_node[i] != STP_NONE) {
            sets[set_of_node[i]].unknown_signs = has_unknown_signs(scene, nodes, i);
        }
    }
    stp_free(context, nodes);
    return STP_OK;
}

stp_result stp_build_note_certainty(const stp_scene* scene, const stp_store_content* content,
                                    stp_build_methods* methods)
{
    const stp_store_directory* d = &content->directory;
    assert(d->node_count == scene->node_count && "the content is not of this scene");
    node_certainty* nodes =
        STP_NEW_ZEROED(scene->context, node_certainty, (size_t)d->node_count + 1);
    if (nodes == NULL) {
        return stp_fail_memory(scene->context);
    }
    find_unknown(scene, nodes);
    find_scales(scene, nodes);
    note_signs(scene, d, nodes, methods->sets);
    for (uint32_t i = 0; i < d->node_count; ++i) {
        const stp_store_node* node = &d->nodes[i];
        for (uint32_t k = 0; k < node->part_count; ++k) {
            stp_store_part part = d->parts[node->first_part + k];
            uint32_t held_by =
                part.kind == STP_STORE_PART_POINTS ? content->point_sets[part.index].held_by : 0;
            assert(held_by <= methods->set_count);
            if (held_by != 0) {
                stp_splats* set = &methods->sets[held_by - 1];
                set->position_error = (float)(0.5 * (double)set->step * nodes[i].scale);
            }
        }
    }
    stp_free(scene->context, nodes);
    return STP_OK;
}
