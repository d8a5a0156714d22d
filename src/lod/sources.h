// SPDX-License-Identifier: MIT
//
// Sources of a node's capture (Brandt 3.4). Descending from the node, a child is represented by a
// prefix of its splats if that is dense enough at the capture's pixel size, and opened otherwise,
// down to parts.
//
//        node captured ─┬─ child: dense enough           -> the shortest prefix that is
//                       ├─ child: not dense enough  ─┬─ its parts          -> triangles
//                       │                            └─ its children ...
//                       └─ moving child                  -> nothing
//
// The traversal is bounded. If there are more instances of parts and sets than `limit`, those
// smaller than a pixel are thinned: they are numbered in traversal order, and only every k-th is
// listed, with the smallest k that fits. If there are too many larger instances, the size limit
// doubles until they fit.
#pragma once

#include "capture/capture.h"

typedef struct stp_source_list {
    stp_placed_part* parts;
    stp_placed_set* sets;
    size_t part_count, part_capacity, set_count, set_capacity;
    uint64_t triangle_count, point_count; ///< counts of everything that the list represents
    uint64_t part_triangles;              ///< triangles of the parts alone
    double splats;                        ///< splats in all sets' prefixes
    /// Approximate pixels covered by the parts in eight directions, without occlusion
    double pixels;
    double coarsest;  ///< the smallest pixel at which all of the listed sets are dense enough
    uint64_t thinned; ///< number of instances left out
} stp_source_list;

/// Lists the sources of `node` for a pixel of `pixel_size`. `sets` may be NULL; the node's own set
/// is ignored. The caller owns the arrays (stp_source_list_destroy), which are empty on failure.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_list_sources(const stp_scene* scene, uint32_t node,
                                         const stp_splats* const* sets, double pixel_size,
                                         size_t limit, stp_source_list* list);
void stp_source_list_destroy(stp_context* context, stp_source_list* list);
