// SPDX-License-Identifier: MIT
#include "program/viewer/model/explorer.h"

#include <assert.h>

enum { NODES_MAX = 256, PARTS_MAX = 4096 };

static void add_material(part_materials* found, uint32_t material)
{
    if (material == STP_STORE_NONE) {
        return;
    }
    for (uint32_t i = 0; i < found->count; ++i) {
        if (found->materials[i] == material) {
            return;
        }
    }
    if (found->count == PART_MATERIALS_MAX) {
        found->more = true;
        return;
    }
    found->materials[found->count++] = material;
}

/// Adds a node to a queue, each node once.
static void enqueue(uint32_t nodes[NODES_MAX], uint32_t* count, uint32_t node, bool* full)
{
    assert(*count <= NODES_MAX);
    for (uint32_t i = 0; i < *count; ++i) {
        if (nodes[i] == node) {
            return;
        }
    }
    if (*count == NODES_MAX) {
        *full = true;
        return;
    }
    nodes[(*count)++] = node;
}

part_materials part_materials_find(const stp_store* store, uint32_t node)
{
    const stp_store_directory* d = stp_store_get_directory(store);
    part_materials found = {0};
    uint32_t nodes[NODES_MAX], count = 0, parts = 0;
    if (node < d->node_count) {
        nodes[count++] = node;
    }
    for (uint32_t i = 0; i < count && !found.more; ++i) {
        const stp_store_node* n = &d->nodes[nodes[i]];
        for (uint32_t k = 0; k < n->part_count && !found.more; ++k) {
            stp_store_part part = d->parts[n->first_part + k];
            bool is_mesh = part.kind == STP_STORE_PART_MESH;
            add_material(&found, is_mesh
                                     ? stp_store_describe_mesh(store, part.index)->material
                                     : stp_store_describe_point_set(store, part.index)->material);
            found.more = found.more || ++parts >= PARTS_MAX;
        }
        for (uint32_t k = 0; k < n->edge_count && !found.more; ++k) {
            enqueue(nodes, &count, d->edges[n->first_edge + k].node, &found.more);
        }
    }
    return found;
}
