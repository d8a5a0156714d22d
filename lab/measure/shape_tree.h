// SPDX-License-Identifier: MIT
//
// Nearest of many disks and triangles: a bounding volume hierarchy over shapes sorted along a
// Morton curve. The tree is balanced, so its depth and build time do not depend on the input.
#pragma once

#include "base/core/context.h"
#include "lab/measure/shapes.h"

typedef struct stp_shape_box {
    float low[3], high[3];
} stp_shape_box;

typedef struct stp_shape_tree {
    stp_shapes shapes;
    uint32_t count; ///< number of shapes; disks come first
    /// Level of the leaves. Level k has 2^k nodes; node i of them holds the places [count i / 2^k,
    /// count (i + 1) / 2^k)
    uint32_t depth;
    uint32_t* order;      ///< shapes along the curve
    stp_shape_box* boxes; ///< boxes of the nodes, level by level
} stp_shape_tree;

/// The arrays of `shapes` must outlive the tree. The same tree for any number of threads.
/// @return STP_OK, STP_ERROR_ARGUMENT (a number is not finite), STP_ERROR_LIMIT (2^32 - 1 shapes or
/// more), STP_ERROR_OUT_OF_MEMORY; logged. On failure there is nothing to destroy
STP_MUST_USE stp_result stp_shape_tree_create(stp_context* context, const stp_shapes* shapes,
                                              stp_shape_tree* tree);
void stp_shape_tree_destroy(stp_context* context, stp_shape_tree* tree);

/// Squared distance from a point to the nearest shape; infinity if the tree is empty. Any thread.
/// @param hint in: a place in `order` that is likely near, such as the result for a nearby point,
/// or UINT32_MAX; out: the place of the nearest shape. Affects only the speed. NULL: none
double stp_shape_tree_distance_squared(const stp_shape_tree* tree, stp_vec3d point, uint32_t* hint);

/// Squared distance from a point to one shape.
/// @param place in `order`, below `count`
double stp_shape_tree_distance_squared_to(const stp_shape_tree* tree, uint32_t place,
                                          stp_vec3d point);
