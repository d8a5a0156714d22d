// SPDX-License-Identifier: MIT
// Which side of each leaf's plane is outside, where the cloud does not say (Bhakar, Luo, Mudur 2004, 3.2).
#pragma once

#include "lod/stochastic/facts.h"

/// Turns representative normals the same way, leaf by leaf: from the highest leaf (largest y), which faces up, to those next to
/// it, and so on. Between two leaves the one's normal is mirrored where the surface bends between them, and the other is turned
/// to it (König, Gumhold 2009), which is the paper's test of their product on flat surface, and right around edges too.
/// Steps along the surface and between like normals come first, so normals do not leak from a sheet to another close to it.
/// Where no leaf is next to any that was reached, the next piece begins at the leaf nearest to those, if the gap is small;
/// else at its own highest one.
/// @param neighbours of each leaf, 1 to STP_LEAF_NEIGHBOURS_MOST: the paper's K
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_orient_leaves(stp_context* context, const stp_leaf_octree* octree,
                                          stp_leaf_facts* facts, uint32_t neighbours);
