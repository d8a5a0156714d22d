// SPDX-License-Identifier: MIT
// A point tree: an octree of points, in which each node is a disk that represents its children
// (Dachsbacher et al. 2003, 3.1 to 3.5).
#pragma once

#include "base/context.h"
#include "lod/spt/disks.h"

/// Input of a tree. Arrays belong to the caller, and are only read.
typedef struct stp_tree_points {
    uint32_t count;
    const float* positions; ///< 3 a point; finite
    const float* normals;   ///< 3 per point, unit length or zero; NULL: unknown
    const uint8_t* colors;  ///< 3 a point, sRGB; NULL: all are white
    const float* radii;     ///< radius of a point's disk; NULL: `radius`
    float radius;
} stp_tree_points;

/// Error measure of nodes.
typedef enum stp_tree_error {
    STP_TREE_GEOMETRIC, ///< of both parts, whatever the direction of view (3.4, "unified")
    STP_TREE_DIAMETER,  ///< its diameter, as in QSplat
} stp_tree_error;

typedef struct stp_tree_desc {
    stp_tree_error error;
    /// If the colour of a child differs by more than this (of 255) from its parent's in any
    /// channel, the parent's error is its diameter (3.9). 255: colours do not count.
    uint32_t color_threshold;
} stp_tree_desc;

/// Nodes in depth-first order: a node before those below it, which lie together behind it. Node 0
/// is the root.
typedef struct stp_point_tree {
    uint32_t count, leaf_count;
    stp_disk* disks;
    uint8_t* colors;  ///< 3 a node, sRGB: means of the leaves below
    uint32_t* ends;   ///< of each node's subtree: the node behind it. A leaf's is the next node
    uint32_t* points; ///< of a leaf the index of its point; else UINT32_MAX
    float* errors;    ///< never below that of a node below; 0 of leaves
    /// The two parts of the error (3.2, 3.3), as they are seen from the side and from above. A
    /// node's are at least its children's, too, and where the error is the diameter, both are.
    float *perpendicular, *tangential;
} stp_point_tree;

/// Makes a tree of at least one point. Coincident points have nodes of their own. Deterministic.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (2^31 points and more; logged). Arrays
/// are freed by
///         stp_point_tree_destroy, also after a failure
STP_MUST_USE stp_result stp_point_tree_make(stp_context* context, const stp_tree_points* points,
                                            const stp_tree_desc* desc, stp_point_tree* tree);
void stp_point_tree_destroy(stp_context* context, stp_point_tree* tree);

/// The view of a tree: an eye in its space, and the error allowed at distance 1 (a pixel's angle
/// times the pixels that are allowed: epsilon of the paper).
typedef struct stp_tree_view {
    stp_vec3d eye;
    double allowed;
    /// Perpendicular and tangential errors count by the angle they are seen at (3.5, "split")
    bool split;
} stp_tree_view;

/// Whether a node's error is allowed at its distance from the eye.
bool stp_point_tree_suffices(const stp_point_tree* tree, uint32_t node, const stp_tree_view* view);

/// The recursive traversal (3.5): the topmost nodes whose error is allowed, and leaves.
/// @param nodes room for tree->leaf_count; ascending. @return how many are selected
uint32_t stp_point_tree_traverse(const stp_point_tree* tree, const stp_tree_view* view,
                                 uint32_t* nodes);
