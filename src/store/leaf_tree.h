// SPDX-License-Identifier: MIT
// The octree over the leaves of a set, made when they are loaded: inner cubes sum up what is in them, so that one that is far
// away is looked at instead of its leaves. Cubes with one part that holds all are left out.
#pragma once

#include <stipple/surfels.h>

#include <stdbool.h>
#include <stddef.h>

/// A cube with all that is in it. A cube is followed by those in it, along the Morton curve.
typedef struct stp_leaf_node {
    uint32_t first, count; ///< places of the row of splats (base/leaf_runs.h)
    uint32_t next;         ///< the node after those in it
    uint32_t leaf_count;   ///< 1: it is a leaf
    float area;            ///< of the surface, in squares of the grid's step
    float flatness;        ///< 0 to 1/3
    uint16_t corner[3];
    uint8_t depth;
    bool edge;
    int8_t normal[2]; ///< representative, octahedral
    uint8_t spread;   ///< sine of how far normals lie from it, of 255; 255: any
    uint8_t spare;
    uint32_t leaf; ///< the first of its leaves
} stp_leaf_node;

/// Most nodes of a tree.
static inline size_t stp_leaf_tree_most(uint32_t leaf_count)
{
    return leaf_count > 0 ? 2 * (size_t)leaf_count - 1 : 0;
}

/// Makes the tree. The leaves are sound (stp_store_leaves_fault).
/// @param nodes room for stp_leaf_tree_most. @return how many there are
uint32_t stp_leaf_tree_make(const stp_splat_leaf* leaves, uint32_t leaf_count,
                            stp_leaf_node* nodes);

/// What is wrong with the leaves of a set; NULL: nothing.
const char* stp_store_leaves_fault(const stp_splats* set, const stp_splat_leaf* leaves,
                                   uint32_t leaf_count);
