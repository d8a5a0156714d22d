// SPDX-License-Identifier: MIT
//
// Restructures a finished scene's graph spatially: neighbours share a node, no node has too many
// children, and no leaf is too large (docs/algorithms/scene.md, Partition). Shared nodes stay
// shared: each is split once, however often it is used.
//
//   a node with 10,000 bolts             a mesh of 20 M triangles
//        |                                      |
//   bounding volume hierarchy over them    split by planes into pieces of at most leaf_triangles,
//   of up to child_count at a node         which hang below a hierarchy likewise
//
// A child as large as its parent (a layer of a drawing, all objects of one material) is dissolved
// into it, so that its content is sorted spatially (partition_steps.h). The result for a subtree depends
// only on the subtree, not on the rest of the scene, except where heavily shared layers reach a
// limit. Moving nodes stay whole. Objects keep their nodes, even those no longer reached from the
// root.
#pragma once

#include "scene/scene.h"

typedef struct stp_partition_desc {
    /// Limit of a leaf; default 400,000: eight times the maximum splats of a node
    uint32_t leaf_triangles;
    uint32_t child_count; ///< maximum edges plus parts of a node; default 16
    /// Limit of a piece of a point set; default leaf_triangles where that is given, else 25,000,
    /// and sets of up to 400,000 points stay whole
    uint32_t leaf_points;
    /// Finds which side of points without normals is outside: a closed surface should be in one
    /// piece, so the default for such sets is 1,000,000 points
    bool finds_signs;
} stp_partition_desc;

/// Call once, after stp_scene_finish. Deterministic for any number of threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (the spill), STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_scene_partition(stp_scene* scene, const stp_partition_desc* desc);
