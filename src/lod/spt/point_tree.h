// SPDX-License-Identifier: MIT
// A point tree: an octree of points, in which each node is a disk that represents its children
// (Dachsbacher et al. 2003, sections 3.1 to 3.5).
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

// Disks that represent nodes of a point tree, and the errors of a disk that replaces its children
// (Dachsbacher et al. 2003, sections 3.1 to 3.4).

enum { STP_DISK_CHILDREN = 8 }; ///< maximum children of an octree node

/// A disk in space. A normal of length 0 makes it a sphere: for points with unknown orientation.
typedef struct stp_tree_disk {
    stp_vec3 center;
    stp_vec3 normal; ///< unit length, or zero
    float radius;
} stp_tree_disk;

/// Errors of a disk that represents its children, in the units of their coordinates; never
/// negative.
typedef struct stp_disk_error {
    /// Distance between the two planes parallel to the disk that enclose all children (3.2)
    float perpendicular;
    /// Maximum excess width of the disk over its children, over all directions (3.3)
    float tangential;
    float geometric; ///< combined: maximum over all view directions (3.4)
} stp_disk_error;

/// Disk with the children's mean normal that encloses their projections along it; a sphere around
/// them if their normals cancel out. Along the normal, its centre is at the children's mean.
/// Usually at most one percent larger than the smallest such disk.
/// @param weights weight of each child in means; positive
stp_tree_disk stp_disk_enclose(const stp_tree_disk* children, const float* weights, uint32_t count);

/// Errors of a disk that represents its children. For a sphere all are its diameter.
stp_disk_error stp_disk_measure(const stp_tree_disk* disk, const stp_tree_disk* children,
                                uint32_t count);

/// Input of a tree. Arrays belong to the caller, and are only read.
typedef struct stp_tree_points {
    uint32_t count;
    const float* positions; ///< 3 per point; finite
    const float* normals;   ///< 3 per point, unit length or zero; NULL: unknown
    const uint8_t* colors;  ///< 3 per point, sRGB; NULL: white
    const float* radii;     ///< radius of a point's disk; NULL: `radius`
    float radius;
} stp_tree_points;

/// Error measure of nodes.
typedef enum stp_tree_error {
    STP_TREE_GEOMETRIC, ///< combined, independent of the view direction (3.4, "unified")
    STP_TREE_DIAMETER,  ///< diameter of the disk, as in QSplat
    /// As STP_TREE_GEOMETRIC; sets also have its two parts, which a view direction weights
    /// ("split")
    STP_TREE_SPLIT,
} stp_tree_error;

typedef struct stp_tree_desc {
    stp_tree_error error;
    /// If any colour channel of a child differs by more than this (of 255) from its parent's, the
    /// parent's error is its diameter (3.9). 255: colours are ignored.
    uint32_t color_threshold;
} stp_tree_desc;

/// Nodes in depth-first order: each node is followed by its descendants. Node 0 is the root.
typedef struct stp_point_tree {
    uint32_t count, leaf_count;
    stp_tree_disk* disks;
    uint8_t* colors;  ///< 3 per node, sRGB: means of the leaves below
    uint32_t* ends;   ///< end of each node's subtree: the index of the next node after it
    uint32_t* points; ///< index of a leaf's point; UINT32_MAX for inner nodes
    float* errors;    ///< at least the children's errors; 0 for leaves
    /// Error components (3.2, 3.3), for views from the side and from above. At least the
    /// children's. Both are the diameter if the error is the diameter.
    float *perpendicular, *tangential;
} stp_point_tree;

/// Makes a tree of at least one point. Each of several coincident points has its own node.
/// Deterministic.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (no points), STP_ERROR_LIMIT (2^31
///         points or more); logged. Freed by stp_point_tree_destroy, also after a failure
STP_MUST_USE stp_result stp_point_tree_make(stp_context* context, const stp_tree_points* points,
                                            const stp_tree_desc* desc, stp_point_tree* tree);
void stp_point_tree_destroy(stp_context* context, stp_point_tree* tree);

/// View of a tree: the eye in the tree's space, and the allowed error at distance 1 (the angle of a
/// pixel times the allowed number of pixels: the paper's epsilon).
typedef struct stp_tree_view {
    stp_vec3d eye;
    double allowed;
    /// Weights perpendicular and tangential errors by the view direction (3.5, "split")
    bool split;
} stp_tree_view;

/// Recursive traversal (3.5): selects the topmost nodes within the allowed error, and leaves.
/// @param nodes space for tree->leaf_count; ascending.
/// @return number of selected nodes
uint32_t stp_point_tree_traverse(const stp_point_tree* tree, const stp_tree_view* view,
                                 uint32_t* nodes);
