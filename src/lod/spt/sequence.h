// SPDX-License-Identifier: MIT
// A point tree as a sequence: a view selects nodes without the tree, by an independent test of each
// node (Dachsbacher et al. 2003, 3.6 and 3.7).
//
// The level of a node in a view is the error allowed at its distance. A node has a range of levels:
// from its own error up to its parent's, and beyond that by how much their levels can differ
// because they lie in two places. So on each way from the root to a leaf the node that the
// recursive traversal takes is selected, and what else is, overlaps it.
#pragma once

#include "lod/spt/point_tree.h"

/// Nodes by falling highest level, so that a view needs a prefix of them.
typedef struct stp_point_sequence {
    uint32_t count;
    uint32_t* nodes;   ///< of the tree
    stp_vec3* centers; ///< of their disks
    float *lowest, *highest;
} stp_point_sequence;

/// @param most_allowed the largest stp_tree_view.allowed that views will have: the larger it is,
/// the more overlaps
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_point_sequence_make(stp_context* context, const stp_point_tree* tree,
                                                double most_allowed, stp_point_sequence* sequence);
void stp_point_sequence_destroy(stp_context* context, stp_point_sequence* sequence);

/// The part of a sequence that may hold what a view selects.
typedef struct stp_sequence_range {
    uint32_t begin, end;
} stp_sequence_range;

/// By the nearest and farthest distance of any node from the eye: nodes from `end` on are too fine
/// for all distances, those before `begin` too coarse (3.7 measures that the latter are few).
stp_sequence_range stp_point_sequence_range(const stp_point_sequence* sequence, double allowed,
                                            double nearest, double farthest);

/// Selects by the test of each node of the range. `view->split` is not regarded.
/// @param nodes room for the range and one more; in the order of the sequence. @return how many are
/// selected
uint32_t stp_point_sequence_select(const stp_point_sequence* sequence, const stp_tree_view* view,
                                   stp_sequence_range range, uint32_t* nodes);
