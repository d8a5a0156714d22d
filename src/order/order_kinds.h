// SPDX-License-Identifier: MIT
// The kinds of orders that stp_order_points selects from.
#pragma once

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
