// SPDX-License-Identifier: MIT
//
// What a capture of a node looks at (Brandt 3.4): walking down from it, each child stands for
// itself by its surfels where a prefix of them is dense enough at the capture's pixel, and is
// opened else, down to parts.
//
//        node captured ─┬─ child: dense enough           -> the shortest prefix that is
//                       ├─ child: not dense enough  ─┬─ its parts          -> triangles
//                       │                            └─ its children ...
//                       └─ moving child                  -> nothing
//
// The walk is bounded. Where more uses of parts and sets come together than `limit`, those smaller
// than a pixel are thinned: they are numbered in the order of the walk, and only every k-th is
// listed, with the smallest k that fits. If what is larger than a pixel is too much already, the
// size below which uses are thinned doubles until it is not.
#pragma once

#include "capture/capture.h"

typedef struct stp_source_list {
    stp_placed_part* parts;
    stp_placed_set* sets;
    size_t part_count, part_capacity, set_count, set_capacity;
    uint64_t triangle_count, point_count; ///< of all the list stands for
    uint64_t part_triangles;              ///< of the parts alone
    double surfels;                       ///< of all sets' prefixes
    double pixels;    ///< about how many the parts cover in eight directions, were nothing hidden
    double coarsest;  ///< the smallest pixel at which all of the listed sets are dense enough
    uint64_t thinned; ///< uses left out
} stp_source_list;

/// Lists the sources of `node` for a pixel of `pixel_size`. `sets` may be NULL; the node's own is
/// not looked at. The arrays are the caller's (stp_source_list_destroy), empty on failure.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_list_sources(const stp_scene* scene, uint32_t node,
                                         const stp_splats* const* sets, double pixel_size,
                                         size_t limit, stp_source_list* list);
void stp_source_list_destroy(stp_context* context, stp_source_list* list);
