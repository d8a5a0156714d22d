// SPDX-License-Identifier: MIT
// Chooses which points of a leaf are kept if there are more candidates than wanted points.
#pragma once

#include "lod/stochastic/facts.h"

/// Keeps the first points of each leaf, in proportion to its area, so that dense leaves lose points and sparse leaves keep all.
/// Removes empty leaves. Exactly `wanted` of the points are left.
/// @param facts of the leaves; `area` is read; they move with the leaves
/// @param ranked the points of each leaf, most important first; moves with the leaves
void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_facts* facts, uint32_t* ranked,
                   uint32_t wanted);
