// SPDX-License-Identifier: MIT
// Candidates straight from point sets: a point cloud needs no capture, and loses no point.
#pragma once

#include "capture/capture.h"

/// Makes every point of the placed point sets a candidate. `has_normals` tells whether all sets have
/// normals; where one has none, those of all points are to be estimated.
/// `pixel_size` is left 0. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged)
STP_MUST_USE stp_result stp_candidates_from_points(const stp_scene* scene,
                                                   const stp_placed_part* parts, size_t part_count,
                                                   stp_candidates* candidates, bool* has_normals);

/// Gives every candidate the normal of the points within `radius` of it, facing up rather than down; where they
/// are too few, straight up. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_estimate_point_normals(stp_context* context, stp_candidates* candidates,
                                                   float radius);
