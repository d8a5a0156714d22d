// SPDX-License-Identifier: MIT
// The order within leaves: the first splats of a leaf that a view draws are spread evenly over it, however few they are.
#pragma once

#include "lod/stochastic/leaf_octree.h"

/// Reorders each leaf's points, which are in random order. First comes the point in the middle, then always the point farthest
/// from all before it, for a quarter of the leaf, at most STP_SPREAD_MOST points. The others stay in random order. Distances wrap
/// around the leaf's cube, as if equal cubes lay next to it, so there is neither a crowd nor a gap at the border of two leaves.
/// Uses all threads.
/// @param ranked each leaf's points in drawing order, as many as octree->order
void stp_spread_order_make(stp_context* context, const uint16_t* positions,
                           const stp_leaf_octree* octree, uint32_t* ranked);

/// Places ranked points so that the octaves of the set draw them in that order (base/leaf_runs.h). Uses all threads.
void stp_spread_order_place(stp_context* context, const uint32_t* ranked, uint32_t count,
                            stp_leaf_octree* octree);

enum { STP_SPREAD_MOST = 512 };
