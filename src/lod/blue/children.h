// SPDX-License-Identifier: MIT
//
// Hierarchical generation (Brandt 3.4): candidates of a node from the splats of its descendants.
#pragma once

#include "lod/blue/blue.h"
#include "lod/sources.h"

/// Maximum instances of parts and sets per capture (sources.h).
#define STP_SOURCE_LIMIT ((size_t)1 << 19)

/// Initial pixel size for a node.
double stp_coarse_pixel(const stp_scene* scene, uint32_t node);

/// Captures the sources of a node at the pixel size that gives about five candidates for each of
/// `splat_count` splats; a small capture measures the hidden share. Sets too coarse for that are
/// opened. If this leads to more than two million triangles or 1.5 million splats, chooses pixels
/// that give only 4.5 candidates per splat, or else four.
/// @param captured false if no set would be used: then nothing was captured
/// @return as stp_capture_all
STP_MUST_USE stp_result stp_capture_children(const stp_scene* scene, uint32_t node,
                                             const stp_blue_desc* desc, uint64_t splat_count,
                                             stp_candidates* candidates, bool* captured);

/// Lists the sources of a cloud at the pixel size that gives about five candidates for each of
/// `splat_count` splats, or as many as there are. @return STP_OK or STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_list_cloud(const stp_scene* scene, uint32_t node,
                                       const stp_blue_desc* desc, uint64_t splat_count,
                                       stp_source_list* list);
