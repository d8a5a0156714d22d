// SPDX-License-Identifier: MIT
//
// Makes a finished scene's graph spatially sensible: what is near each other hangs below one node, no node has
// too many children, and no leaf is too large (design.md, Partition). Shared nodes stay shared: each is cut
// once, wherever it stands.
//
//   a node with 10,000 bolts             a mesh of 20 M triangles
//        |                                      |
//   bounding volume hierarchy over them    cut by planes into pieces of at most leaf_triangles,
//   of up to child_count at a node         which hang below a hierarchy likewise
//
// A child that spreads as wide as its parent (a layer of a drawing, all that is of one material) is dissolved
// into it, so that its content is sorted by place (wide.h). What becomes of a subtree is a function of what is in it,
// whatever else the scene holds, within bounds that only much shared layers reach. Moving nodes are left whole.
// Objects keep their nodes, also where those are no longer reached from the root.
#pragma once

#include "scene/scene.h"

typedef struct stp_partition_desc {
    uint32_t
        leaf_triangles; ///< most triangles of a leaf; default 400,000: twice the most surfels (Brandt 5.2)
    uint32_t child_count; ///< most edges and parts of a node together; default 16
} stp_partition_desc;

/// Call once, after stp_scene_finish. Deterministic for any number of threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (the spill), STP_ERROR_LIMIT, STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_scene_partition(stp_scene* scene, const stp_partition_desc* desc);
