// SPDX-License-Identifier: MIT
// Orients the normals of leaves if the cloud has no normals (Bhakar, Luo, Mudur 2004, 3.2).
#pragma once

#include "lod/stochastic/leaf_properties.h"

/// Turns representative normals consistently: starts at the highest leaf (largest y), which faces
/// up, and proceeds to neighbouring leaves. Between two leaves, the first normal is mirrored as the
/// surface bends between them, and the other one is turned to match it (König, Gumhold 2009). On
/// flat surfaces this is the paper's dot product test; it also works around edges. Steps along a
/// surface and between similar normals come first, so orientation does not leak between close
/// sheets. If no neighbour is left, continues with the leaf nearest to the oriented ones if the gap
/// is small; otherwise with the highest leaf of the next component.
/// @param neighbours per leaf, 1 to STP_LEAF_NEIGHBOURS_MAX: the paper's K
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_orient_leaves(stp_context* context, const stp_leaf_octree* octree,
                                          stp_leaf_properties* properties, uint32_t neighbours);
