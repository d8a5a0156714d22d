// SPDX-License-Identifier: MIT
// A circular splat for each point, and which points are neighbours (Wu, Zhang, Kobbelt 2005, 3).
#pragma once

#include "lod/psp/forest.h"
#include "lod/psp/kd_tree.h"

/// The splat of a point: a circle in the plane that lies nearest to the point and its neighbours,
/// as wide as the farthest of them. A given normal says which side is outside; without one, a splat
/// faces along the largest coordinate of its normal.
/// @param places of the neighbours in the tree (stp_kd_nearest)
/// @param given of unit length, or zero
/// @param alone radius where no neighbour lies in another place
stp_ellipse stp_psp_initial_splat(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                                  uint32_t count, stp_vec3 given, float alone);

/// The radius of splats without neighbours: a thousandth of the size of the whole; 1 where that is
/// not above 0 or not finite.
float stp_psp_radius_alone(float size);

/// Finds the k nearest neighbours of each point, and makes its splat.
/// @param ellipses room for point_count. @param neighbours room for k a point
/// (stp_find_nearest_points)
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make_initial(stp_context* context, const stp_psp_points* points,
                                             uint32_t k, stp_ellipse* ellipses,
                                             uint32_t* neighbours);
