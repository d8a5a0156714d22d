// SPDX-License-Identifier: MIT
//
// A bounding volume hierarchy for ray casting, built with the surface area heuristic over 16 bins
// (Wald, On fast Construction of SAH-based Bounding Volume Hierarchies, 2007). The same tree on
// every machine.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

typedef struct stp_box_node {
    float low[3], high[3];
    uint32_t first; ///< index of the first of two adjacent children; leaves: a place in `order`
    uint32_t count; ///< items in a leaf; 0: the node has children
} stp_box_node;

enum { STP_BOX_TREE_DEPTH = 96 }; ///< upper bound on the number of levels

typedef struct stp_box_tree {
    stp_box_node* nodes; ///< root first; NULL if the tree is empty
    uint32_t* order;     ///< items; those of a leaf are consecutive
    uint32_t count;      ///< number of items
} stp_box_tree;

/// Builds the tree of `count` non-empty boxes, fewer than 2^31. May run inside jobs.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (not logged; there is nothing to destroy)
STP_MUST_USE stp_result stp_box_tree_create(stp_context* context, const stp_box* boxes,
                                            uint32_t count, stp_box_tree* tree);
void stp_box_tree_destroy(stp_context* context, stp_box_tree* tree);

/// A ray, prepared for box tests.
typedef struct stp_box_ray {
    double origin[3];
    double inverse[3]; ///< 1 / direction; large for components of 0
} stp_box_ray;

stp_box_ray stp_box_ray_make(stp_vec3d origin, stp_vec3d direction);

/// Visits items whose leaf the ray enters between `nearest` and `*farthest`, in the order in which
/// boxes are entered. `look` may lower `*farthest`.
void stp_box_tree_walk(const stp_box_tree* tree, const stp_box_ray* ray, double nearest,
                       const double* farthest, void (*look)(uint32_t item, void* user), void* user);
