// SPDX-License-Identifier: MIT
// The kinds of orders that stp_order_points selects from.
#pragma once

#include "order/near_grid.h"
#include "order/points.h"

#include <stipple/order.h>

/// Output of an order: see stp_order_points. Radii are in the points' own units.
typedef struct stp_order_output {
    uint32_t wanted; ///< at most the number of points, at least 1
    uint32_t* order;
    float* radii; ///< may be NULL
    uint32_t ordered;
    float* final_radius; ///< may be NULL
    stp_order_report report;
} stp_order_output;

// Each fills the output. @return STP_OK, or STP_ERROR_OUT_OF_MEMORY or STP_ERROR_CANCELLED (logged)
STP_MUST_USE stp_result stp_order_exact(const stp_points* points, const stp_team* team,
                                        const stp_order_desc* desc, stp_order_output* output);
STP_MUST_USE stp_result stp_order_sampled(const stp_points* points, const stp_team* team,
                                          const stp_order_desc* desc, stp_order_output* output);
STP_MUST_USE stp_result stp_order_random(const stp_points* points, const stp_team* team,
                                         const stp_order_desc* desc, stp_order_output* output);

// Coverage radius of a chosen subset, for orders that do not compute it themselves.

/// Creates an empty grid for points chosen from this set.
STP_MUST_USE stp_result stp_cover_create_grid(const stp_points* points, stp_context* context,
                                              stp_near_grid* grid);

/// Largest distance from a point to the grid's points, in the points' own units.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cover_radius(const stp_points* points, const stp_team* team,
                                         const stp_near_grid* grid, float* radius);

// Distances from points to the nearest point of lower rank, for orders that do not compute them
// themselves.

/// Computes the output's radii and final radius, where wanted, from its order. Adds the evaluated
/// distances to the report. Work per point does not depend on how evenly the points are spread.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_earlier_measure(const stp_points* points, const stp_team* team,
                                            stp_order_output* output);
