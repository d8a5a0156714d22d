// SPDX-License-Identifier: MIT
// Features at several scales (Pauly, Keiser, Gross 2003; Bhakar, Luo, Mudur 2004, 5): what the points of a leaf show counts if the
// cubes around it show it as well. Noise bends and breaks a surface at the finest scale alone.
#pragma once

#include "lod/stochastic/facts.h"

enum { STP_LEAF_SCALES_MOST = 4 };

/// Limits flatness and edges of leaves to what lasts over scales: the leaf's cube and the `scales` - 1 cubes around it, each of
/// twice the width, from the merged scatter of their leaves. Lasting flatness is the least of all. An edge lasts if flatness falls
/// from no scale to the next by more than half: that of an edge stays, that of a bend grows fourfold, that of noise falls to a
/// quarter. On all threads.
/// @param scatters of each leaf, relative to its corner
/// @param scales 1 to STP_LEAF_SCALES_MOST; 1: the leaf alone, nothing changes
void stp_leaf_facts_of_scales(stp_context* context, const stp_leaf_octree* octree,
                              const stp_scatter* scatters, uint32_t scales, stp_leaf_facts* facts);
