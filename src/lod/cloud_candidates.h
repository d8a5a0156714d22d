// SPDX-License-Identifier: MIT
// Candidates of a point cloud, which needs no capture: its points, or the surfels that represent
// them.
#pragma once

#include "lod/sources.h"

/// Turns every point of a list's point sets, and every surfel of its surfel sets, into a candidate,
/// hidden or not. `pixel_size` stays 0.
/// @param has_normals takes normals from the point sets; otherwise sets (0, 1, 0), to be estimated
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_candidates_of_cloud(const stp_scene* scene, const stp_source_list* list,
                                                bool has_normals, stp_candidates* candidates);

/// Whether all point sets of a list have normals.
bool stp_sources_have_normals(const stp_scene* scene, const stp_source_list* list);
