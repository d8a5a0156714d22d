// SPDX-License-Identifier: MIT
// A circular splat for each point, and neighbour lists (Wu, Zhang, Kobbelt 2005, section 3).
#pragma once

#include "lod/psp/forest.h"
#include "lod/psp/kd_tree.h"

/// Initial splat of a point: a circle in the least-squares plane of the point and its neighbours,
/// whose radius is the largest distance to a neighbour within that plane. A given normal determines
/// which side is outside; without one, the largest coordinate of the normal is made positive.
/// @param places places of the neighbours in the tree (stp_kd_nearest)
/// @param given of unit length, or zero
/// @param alone radius if all neighbours coincide with the point
stp_ellipse stp_psp_initial_splat(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                                  uint32_t count, stp_vec3 given, float alone);

/// Radius of splats without neighbours: a thousandth of the total size; 1 if `size` is not positive
/// or not finite.
float stp_psp_radius_alone(float size);

/// Finds the k nearest neighbours of each point, and makes its splat.
/// @param ellipses space for one per point
/// @param neighbours space for k per point (stp_find_nearest_points)
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_psp_make_initial(stp_context* context, const stp_psp_points* points,
                                             uint32_t k, stp_ellipse* ellipses,
                                             uint32_t* neighbours);
