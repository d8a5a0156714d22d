// SPDX-License-Identifier: MIT
// A circular splat for each point, and which points are neighbours (Wu, Zhang, Kobbelt 2005, 3).
#pragma once

#include "lod/psp/forest.h"

/// Finds the k nearest neighbours of each point, and makes its splat: in the plane that lies nearest to them all, as wide as the
/// farthest of them. Given normals say which side is outside; without any, a splat faces up its largest coordinate. Of a
/// point without neighbours in another place the splat is a thousandth of the whole, or 1 wide.
/// @param ellipses room for point_count. @param neighbours room for k a point (stp_find_nearest_points)
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make_initial(stp_context* context, const stp_psp_points* points,
                                             uint32_t k, stp_ellipse* ellipses,
                                             uint32_t* neighbours);
