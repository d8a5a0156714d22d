// SPDX-License-Identifier: MIT
// Candidates of a point cloud, which needs no capture: its points, or the surfels that stand for them.
#pragma once

#include "lod/sources.h"

/// Makes every point of a list's point sets, and every surfel of its surfel sets, a candidate, hidden or not.
/// @param has_normals  normals are taken from the point sets; else they are left (0, 1, 0), to be estimated
/// `pixel_size` is left 0. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_candidates_of_cloud(const stp_scene* scene, const stp_source_list* list,
                                                bool has_normals, stp_candidates* candidates);

/// Whether all point sets of a list have normals.
bool stp_sources_have_normals(const stp_scene* scene, const stp_source_list* list);

/// Gives candidates that are points the normal of the candidates within `radius` of them, facing up rather than down. Where
/// they are fewer than four, itself included, the radius is doubled, up to four times; where that does not help, the normal is
/// straight up. Surfels of sets keep theirs.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                                   float radius);
