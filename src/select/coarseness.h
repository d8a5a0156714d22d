// SPDX-License-Identifier: MIT
// How coarse a budget makes frames: one number for the size of splats and the resolution. Up to
// STP_SPLAT_SIZE_COARSEST it is that size. Beyond, the resolution falls, and splats keep that size in
// pixels of the whole picture.
#pragma once

#include "select/budget.h"

/// Share of the picture's width and height: STP_RESOLUTION_MIN to 1, in steps of 1/16.
static inline double stp_coarseness_resolution(double coarseness)
{
    const double steps = 16.0, full = (double)STP_SPLAT_SIZE_COARSEST;
    double share = floor(full / coarseness * steps + 0.5) / steps;
    return stp_clampd(share, STP_RESOLUTION_MIN, 1.0);
}

/// How coarse a frame was. A frame of larger splats, which somebody asked for, had all pixels.
static inline double stp_coarseness_of(const stp_frame_cost* cost)
{
    double resolution = stp_frame_resolution(cost);
    return resolution < 1.0 ? (double)STP_SPLAT_SIZE_COARSEST / resolution
                            : stp_mind((double)cost->splat_size, (double)STP_SPLAT_SIZE_COARSEST);
}

/// What the counts of a frame are multiplied with at a resolution: splats, fragments, triangles,
/// draws and covered pixels. The error of triangles is in pixels as drawn.
static inline void stp_coarseness_factors(double resolution, double factors[STP_BUDGET_TERMS])
{
    factors[0] = factors[3] = 1.0;
    factors[1] = factors[4] = resolution * resolution;
    factors[2] = resolution;
}
