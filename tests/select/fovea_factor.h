// SPDX-License-Identifier: MIT
// The factor of a fovea at one point.
#pragma once

#include "select/eyes.h"
#include "select/view_frame.h"

/// The factor at a distance from the gaze point, in half diagonals: that of a rectangle without
/// extent, in a picture whose half diagonal is 1.
static inline double fovea_factor_at(const stp_fovea* fovea, double radius)
{
    const stp_view_frame frame = {.width = 2.0};
    stp_fovea centered = *fovea;
    double minimum, greatest;
    centered.center[0] = centered.center[1] = 0.0f;
    const stp_view_rectangle point = {.x0 = 1.0, .x1 = 1.0, .y0 = radius, .y1 = radius};
    stp_fovea_bound(&centered, &frame, &point, &minimum, &greatest);
    return minimum;
}
