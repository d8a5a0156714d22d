// SPDX-License-Identifier: MIT
//
// Compares the visible surface of an approximation: holes, and background surfaces that show
// through.
#pragma once

#include <stipple/base.h>

/// One sample per pixel. `nearness` is 0 if nothing was drawn, else proportional to 1 / depth, with
/// the same factor in both frames.
typedef struct stp_surface_frame {
    uint32_t width, height;
    const float* nearness;
} stp_surface_frame;

typedef struct stp_surface_errors {
    uint64_t covered;     ///< pixels covered by the reference
    uint64_t interior;    ///< covered pixels more than two pixels inside the silhouette
    uint64_t holes;       ///< interior pixels that are empty in the other frame
    uint64_t wrong_depth; ///< covered by both, and the other frame is behind the reference there
    uint64_t drawn;       ///< pixels covered by the other frame
    uint64_t extra;       ///< drawn pixels that the reference does not cover
} stp_surface_errors;

/// Counts the errors of `frame` against `reference` (same size). A pixel has a wrong depth if it
/// lies behind everything the reference shows within two pixels of it, by more than `tolerance`
/// times a pixel's size at that depth. `pixel_angle` is the size of a pixel at depth 1.
void stp_surface_compare(const stp_surface_frame* reference, const stp_surface_frame* frame,
                         double pixel_angle, double tolerance, stp_surface_errors* errors);
