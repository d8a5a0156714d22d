// SPDX-License-Identifier: MIT
// Fewer points than there are candidates: which of a leaf's are kept.
#pragma once

#include "lod/stochastic/facts.h"

/// Keeps the first of each leaf's points: as many as its area is worth, so that dense places give up points and sparse ones keep
/// all. Leaves without any go. Exactly `wanted` points are left, of more.
/// @param facts of the leaves; their `area` is read, they move with the leaves
/// @param ranked the points of each leaf, the first to keep first; moves with the leaves
void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_facts* facts, uint32_t* ranked,
                   uint32_t wanted);
