// SPDX-License-Identifier: MIT
//
// Hierarchical generation (Brandt 3.4): the candidates of a node from the surfels of what lies below it.
#pragma once

#include "lod/blue/blue.h"
#include "lod/sources.h"

/// Most uses of parts and sets that one capture looks at (sources.h).
#define STP_SOURCE_LIMIT ((size_t)1 << 19)

/// A pixel for looking at a node before anything is known of it.
double stp_coarse_pixel(const stp_scene* scene, uint32_t node);

/// Captures the sources of a node at the pixel that gives about seven candidates for each of `surfel_count` surfels; a
/// small capture tells how much is hidden. Sets too coarse for that are opened. Where this leads to more than two million triangles, sets are used that
/// give only six candidates a surfel, or as many as they have, at least four.
/// @param captured  false where no set would be used: then nothing was captured
/// @return as stp_capture_all
STP_MUST_USE stp_result stp_capture_children(const stp_scene* scene, uint32_t node,
                                             const stp_blue_desc* desc, uint64_t surfel_count,
                                             stp_candidates* candidates, bool* captured);

/// Lists the sources of a cloud at the pixel that gives about five candidates for each of `surfel_count` surfels, or as many
/// as there are. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_list_cloud(const stp_scene* scene, uint32_t node,
                                       const stp_blue_desc* desc, uint64_t surfel_count,
                                       stp_source_list* list);
