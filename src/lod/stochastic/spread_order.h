// SPDX-License-Identifier: MIT
// The order within leaves: the first splats that a view draws of a leaf are spread evenly over it, however few they are.
#pragma once

#include "lod/stochastic/leaf_octree.h"

/// Reorders each leaf's points, which are in random order. The points drawn first are the one in the middle, then always the one
/// farthest from those before it, for a quarter of the leaf but at most STP_SPREAD_MOST points; the others stay in random order.
/// Distances are measured across opposite sides of the leaf's cube, as if equal cubes lay around it: so neither do points crowd
/// at the border between two leaves, nor is there a gap.
/// On all threads.
/// @param ranked each leaf's points in the order in which they are drawn, as many as octree->order
void stp_spread_order_make(stp_context* context, const uint16_t* positions,
                           const stp_leaf_octree* octree, uint32_t* ranked);

/// Puts ranked points where the octaves of the set draw them in that order (base/leaf_runs.h). On all threads.
void stp_spread_order_place(stp_context* context, const uint32_t* ranked, uint32_t count,
                            stp_leaf_octree* octree);

enum { STP_SPREAD_MOST = 512 };
