// SPDX-License-Identifier: MIT
// Finds the outside of each leaf's plane for clouds without oriented normals (Bhakar, Luo, Mudur 2004, 3.2).
#pragma once

#include "lod/stochastic/facts.h"

/// Orients the representative normals consistently. Starts at the highest leaf (largest y), which faces up, and proceeds to its
/// neighbours. Each step mirrors the first normal in the plane between both leaves, and turns the second to it (König, Gumhold
/// 2009). On a flat surface this is the paper's dot-product test; it also holds around edges. Steps along the surface and between
/// similar normals come first, so orientation does not leak between sheets that nearly touch. A piece that no step reaches starts
/// at the leaf nearest to oriented ones if the gap is small, else at its own highest leaf.
/// @param neighbours per leaf, 1 to STP_LEAF_NEIGHBOURS_MOST: the paper's K
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_orient_leaves(stp_context* context, const stp_leaf_octree* octree,
                                          stp_leaf_facts* facts, uint32_t neighbours);
