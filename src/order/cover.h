// SPDX-License-Identifier: MIT
// How far points lie from the ones chosen, where that is not known on the way.
#pragma once

#include "order/near_grid.h"
#include "order/points.h"

/// An empty grid for the chosen among these points.
STP_MUST_USE stp_result stp_cover_create_grid(const stp_points* points, stp_context* context,
                                              stp_near_grid* grid);

/// The distance of the farthest point to the grid's, in the points' own units.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_radius(const stp_points* points, const stp_team* team,
                                         const stp_near_grid* grid, float* radius);
