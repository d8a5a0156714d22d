// SPDX-License-Identifier: MIT
// Coverage radius of a chosen subset, for orders that do not compute it themselves.
#pragma once

#include "order/near_grid.h"
#include "order/points.h"

/// Creates an empty grid for points chosen from this set.
STP_MUST_USE stp_result stp_cover_create_grid(const stp_points* points, stp_context* context,
                                              stp_near_grid* grid);

/// Largest distance from a point to the grid's points, in the points' own units.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_radius(const stp_points* points, const stp_team* team,
                                         const stp_near_grid* grid, float* radius);
