// SPDX-License-Identifier: MIT
// Distances from points to the nearest point of lower rank, for orders that do not compute them
// themselves.
#pragma once

#include "order/order_kinds.h"

/// Computes the output's radii and final radius, where wanted, from its order. Adds the evaluated
/// distances to the report. Work per point does not depend on how evenly the points are spread.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_earlier_measure(const stp_points* points, const stp_team* team,
                                            stp_order_output* output);
