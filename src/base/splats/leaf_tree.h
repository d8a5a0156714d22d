// SPDX-License-Identifier: MIT
// The octree over the leaves of a set, built when they are loaded. Inner cubes sum up their
// content, so that a distant cube replaces its leaves. Cubes with a single child are left out.
#pragma once

#include "base/splats/splat_columns.h"

#include <stdbool.h>
#include <stddef.h>

/// Flatness of a region that counts as bent; more makes no difference (Bhakar 2004, Table 1).
#define STP_LEAF_BENT 0.005f

/// A cube and everything inside it. Its descendants follow it, in Morton order.
typedef struct stp_leaf_node {
    uint32_t first, count; ///< range of the splat row (base/splats/leaf_runs.h)
    uint32_t next;         ///< the next node after its descendants
    uint32_t leaf_count;   ///< 1: it is a leaf itself
    float area;            ///< surface area, in squares of the grid step
    float flatness;        ///< 0 to STP_LEAF_BENT; of a cube the mean over its area
    float edge;            ///< share of the area in leaves with an edge: 0 or 1 of a leaf
    float edge_flatness;   ///< mean flatness of that area
    float turn;            ///< mean of the leaves' spreads over the area, 0 to 1
    uint32_t leaf;         ///< index of its first leaf
    uint16_t corner[3];
    uint8_t depth;
    int8_t normal[2]; ///< representative, octahedral
    uint8_t spread;   ///< sine of the largest deviation from it, times 255; 255: unbounded
} stp_leaf_node;

/// Maximum number of nodes of a tree.
static inline size_t stp_leaf_tree_max_nodes(uint32_t leaf_count)
{
    return leaf_count > 0 ? 2 * (size_t)leaf_count - 1 : 0;
}

/// Builds the tree. The leaves must be valid (stp_splat_leaves_fault).
/// @param nodes room for stp_leaf_tree_max_nodes.
/// @return the number of nodes
uint32_t stp_leaf_tree_make(const stp_splat_leaf* leaves, uint32_t leaf_count,
                            stp_leaf_node* nodes);

/// What is wrong with the leaves of a set, or NULL.
const char* stp_splat_leaves_fault(const stp_splats* set, const stp_splat_leaf* leaves,
                                   uint32_t leaf_count);
