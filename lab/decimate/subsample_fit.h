// SPDX-License-Identifier: MIT
// Fits final splats of chosen candidates: no larger than their points need.
#pragma once

#include "lab/decimate/subsample_cover.h"
#include "lab/decimate/subsample_grow.h"

/// A cover by candidates of a field.
typedef struct stp_subsample_choice {
    const stp_subsample_field* field;
    const stp_subsample_candidates* candidates;
    const stp_cover_problem* problem;
    const stp_cover* cover;
} stp_subsample_choice;

/// Assigns each point to one of the chosen candidates that cover it, moves each candidate in its
/// plane to the centre of its points, and repeats. The final ellipses contain their points with
/// margins. A candidate without points has no splat. Uses all threads; results do not depend on
/// their number.
/// @param ellipses space for all chosen ones
/// @param colors 3 per splat, sRGB: means, in linear light, of the covered points; white without
/// colours
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_subsample_fit(stp_context* context, const stp_subsample_choice* choice,
                                          stp_ellipse* ellipses, uint8_t* colors, uint32_t* count);
