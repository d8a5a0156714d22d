// SPDX-License-Identifier: MIT
// Features at several scales (Pauly, Keiser, Gross 2003; Bhakar, Luo, Mudur 2004, 5). A feature of
// a leaf counts if the cubes around the leaf show it too. Noise bends and breaks a surface only at
// the finest scale.
#pragma once

#include "lod/stochastic/leaf_properties.h"

enum { STP_LEAF_SCALES_MAX = 4 };

/// Limits flatness and edges to what lasts over the scales: the leaf's cube and the `scales` - 1
/// cubes around it, each twice as wide. The scatter of a cube is merged from its leaves. Lasting
/// flatness is the minimum over the scales. An edge lasts if flatness never falls by more than half
/// from a scale to the next one: from scale to scale, the flatness of an edge stays, that of a bend
/// grows fourfold, and that of noise falls to a quarter. Uses all threads.
/// @param scatters per leaf, relative to its corner
/// @param scales 1 to STP_LEAF_SCALES_MAX; with 1 nothing changes
void stp_leaf_measure_scales(stp_context* context, const stp_leaf_octree* octree,
                             const stp_scatter* scatters, uint32_t scales,
                             stp_leaf_properties* properties);
