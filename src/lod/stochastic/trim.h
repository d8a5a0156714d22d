// SPDX-License-Identifier: MIT
// Reduces the number of points: chooses which of each leaf's points are kept.
#pragma once

#include "lod/stochastic/leaf_properties.h"

/// Keeps the first of each leaf's points in proportion to the leaf's area, so that dense places
/// lose points and sparse ones keep all. Removes empty leaves. Exactly `wanted` points remain;
/// there must be more before.
/// @param properties properties of the leaves; reads `area`, and moves them with the leaves
/// @param ranked points of each leaf, those to keep first; moves them with the leaves
void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_properties* properties, uint32_t* ranked,
                   uint32_t wanted);
