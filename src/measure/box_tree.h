// SPDX-License-Identifier: MIT
//
// A tree of boxes over many things, for rays. It is split where rays are likely to test the fewest
// boxes (surface area heuristic over 16 bins: Wald, On fast Construction of SAH-based Bounding
// Volume Hierarchies, 2007). The same tree on every machine.
#pragma once

#include "base/context.h"
#include "base/math.h"

typedef struct stp_box_node {
    float low[3], high[3];
    uint32_t first; ///< of two children, which stand together; of a leaf: a place in `order`
    uint32_t count; ///< things of a leaf; 0: the node has children
} stp_box_node;

enum { STP_BOX_TREE_DEPTH = 96 }; ///< levels of nodes are fewer

typedef struct stp_box_tree {
    stp_box_node* nodes; ///< the root first; NULL where there is no thing
    uint32_t* order;     ///< things, those of a leaf one after the other
    uint32_t count;      ///< of things
} stp_box_tree;

/// Makes the tree of `count` boxes, fewer than 2^31, none of them empty. May run inside jobs.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY, which is not logged; then nothing is to be destroyed
STP_MUST_USE stp_result stp_box_tree_create(stp_context* context, const stp_box* boxes,
                                            uint32_t count, stp_box_tree* tree);
void stp_box_tree_destroy(stp_context* context, stp_box_tree* tree);

/// A ray as boxes see it.
typedef struct stp_box_ray {
    double origin[3];
    double inverse[3]; ///< 1 / direction; large where that is 0
} stp_box_ray;

stp_box_ray stp_box_ray_make(stp_vec3d origin, stp_vec3d direction);

/// Looks at things whose leaf the ray enters between `nearest` and `*farthest`, boxes that are
/// entered first before others. `look` may lower `*farthest`.
void stp_box_tree_walk(const stp_box_tree* tree, const stp_box_ray* ray, double nearest,
                       const double* farthest, void (*look)(uint32_t thing, void* user),
                       void* user);
