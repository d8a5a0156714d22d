// SPDX-License-Identifier: MIT
// Passes over the leaves of a set: features at several scales, orientation of normals, the number of
// points, and their order.
#pragma once

#include "lod/stochastic/leaf_octree.h"
#include "lod/stochastic/leaf_properties.h"

// Features at several scales (Pauly, Keiser, Gross 2003; Bhakar, Luo, Mudur 2004, 5). A feature of
// a leaf counts if the cubes around the leaf show it too. Noise bends and breaks a surface only at
// the finest scale.

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

// Orients the normals of leaves if the cloud has no normals (Bhakar, Luo, Mudur 2004, 3.2).

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

// Reduces the number of points: chooses which of each leaf's points are kept.

/// Keeps the first of each leaf's points in proportion to the leaf's area, so that dense places
/// lose points and sparse ones keep all. Removes empty leaves. Exactly `wanted` points remain;
/// there must be more before.
/// @param properties properties of the leaves; reads `area`, and moves them with the leaves
/// @param ranked points of each leaf, those to keep first; moves them with the leaves
void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_properties* properties, uint32_t* ranked,
                   uint32_t wanted);

// Order within leaves: the first splats that a view draws of a leaf are evenly spread over it.

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
