// SPDX-License-Identifier: MIT
// Split errors of a sequence (Dachsbacher et al. 2003, 3.5 and 3.7): by which shares a view
// direction lowers the levels of a node's range.
#pragma once

#include "lod/spt/node_splats.h"

/// By which factor the ranges of a node's children overlap more than with unified errors. A view
/// sees the node and a child from two directions, so the node's error differs in the two
/// (docs/algorithms/point-trees.md, Split errors).
double stp_split_overlap(const stp_point_tree* tree, uint32_t node);

/// Makes the code of each node (`errors` in base/splats/splat_codes.h).
/// @param splats of the nodes
/// @param max_allowed of the tree's sequence
/// @param codes receives one per node
void stp_split_errors_make(stp_context* context, const stp_point_tree* tree,
                           const stp_node_splat* splats, double max_allowed, uint32_t* codes);
