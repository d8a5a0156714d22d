// SPDX-License-Identifier: MIT
// Order within leaves: the first splats that a view draws of a leaf are evenly spread over it.
#pragma once

#include "lod/stochastic/leaf_octree.h"

/// Reorders each leaf's points, which are in random order. First comes the point in the middle,
/// then repeatedly the one farthest from those before it, for a quarter of the leaf but at most
/// STP_SPREAD_MAX points. The others stay in random order. Distances wrap around at opposite sides
/// of the leaf's cube, as if it were surrounded by copies of itself. So at the border between two
/// leaves, points neither crowd nor leave a gap. On all threads.
/// @param ranked receives each leaf's points in drawing order; as many as octree->order
void stp_spread_order_make(stp_context* context, const uint16_t* positions,
                           const stp_leaf_octree* octree, uint32_t* ranked);

/// Moves ranked points to the places at which the octaves of the set draw them in that order
/// (base/splats/leaf_runs.h). On all threads.
void stp_spread_order_place(stp_context* context, const uint32_t* ranked, uint32_t count,
                            stp_leaf_octree* octree);

enum { STP_SPREAD_MAX = 512 };
