// SPDX-License-Identifier: MIT
// A point tree as a sequence: views select nodes without the tree, by an independent test per node
// (Dachsbacher et al. 2003, sections 3.6 and 3.7).
//
// The level of a node in a view is the allowed error at its distance. A node's range of levels
// extends from its own error to its parent's, plus the maximum difference of their levels caused by
// their different positions. So on each path from the root to a leaf, the node that the recursive
// traversal selects is selected; other selected nodes overlap it.
#pragma once

#include "lod/spt/point_tree.h"

/// Nodes sorted by descending highest level, so that a view needs only a prefix.
typedef struct stp_point_sequence {
    uint32_t count;
    uint32_t* nodes;         ///< node of the tree
    stp_vec3* centers;       ///< centres of the nodes' disks
    float *lowest, *highest; ///< range of levels of each node
} stp_point_sequence;

/// @param max_allowed maximum stp_tree_view.allowed of any view; larger values cause more overlap
/// @param split the ranges are those of split errors: they overlap more (split_errors.h)
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_point_sequence_make(stp_context* context, const stp_point_tree* tree,
                                                double max_allowed, bool split,
                                                stp_point_sequence* sequence);
/// Highest level of a child: its parent's error, and how far their levels can differ in views that
/// allow up to `max_allowed`.
float stp_point_sequence_highest(const stp_point_tree* tree, uint32_t parent, uint32_t child,
                                 double max_allowed);
void stp_point_sequence_destroy(stp_context* context, stp_point_sequence* sequence);

/// The part of a sequence that a view may select from.
typedef struct stp_sequence_range {
    uint32_t begin, end;
} stp_sequence_range;

/// Computed from the minimum and maximum distance of all nodes from the eye. Nodes from `end` on
/// are too fine for all distances, those before `begin` too coarse (3.7 measures that these are
/// few).
stp_sequence_range stp_point_sequence_range(const stp_point_sequence* sequence, double allowed,
                                            double nearest, double farthest);

/// Tests each node of the range. Ignores `view->split`.
/// @param nodes space for one more than the range; in sequence order.
/// @return number of selected nodes
uint32_t stp_point_sequence_select(const stp_point_sequence* sequence, const stp_tree_view* view,
                                   stp_sequence_range range, uint32_t* nodes);
