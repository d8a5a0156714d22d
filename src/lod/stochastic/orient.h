// SPDX-License-Identifier: MIT
// Which side of each patch is outside, where the cloud does not say (Bhakar, Luo, Mudur 2004, 3.2).
#pragma once

#include "lod/stochastic/patches.h"

/// Turns normals the same way, patch by patch: from the highest one (largest y), which faces up, to
/// those next to it, and so on (patch_links.h). Steps along the surface and between like normals
/// come first, so normals do not leak from a sheet to another close to it. Where no patch is next
/// to any that was reached, the next piece begins at the patch nearest to those, if the gap is
/// small; else at its own highest one. Afterwards parts are turned where more neighbours then agree
/// (turn_subtrees.h).
/// @param neighbours of each patch, 1 to STP_LEAF_NEIGHBOURS_MOST: the paper's K
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_orient_patches(stp_context* context, const stp_leaf_octree* octree,
                                           stp_patches* patches, uint32_t neighbours);
