// SPDX-License-Identifier: MIT
// Fixed-size points: which items have them, and their size. Such a point is a disk that faces the
// eye, drawn in full.
#pragma once

#include "draw/draw.h"

#include <assert.h>

/// Depth of a point's rim behind its centre, in radii: a pixel of overlapping points shows the one
/// with the nearest centre.
#define STP_POINT_RIM_DEPTH 1.0f

/// Radius of an item's points: one of the two is 0.
typedef struct stp_point_radius {
    float units;  ///< in item space
    float pixels; ///< on the screen
} stp_point_radius;

static inline bool stp_point_size_is_fixed(const stp_draw_style* style, const stp_draw_item* item)
{
    return style->point_sizing != STP_POINTS_ADAPTIVE && item->of_points;
}

static inline stp_point_radius stp_point_radius_of(const stp_draw_style* style,
                                                   const stp_draw_item* item)
{
    assert(stp_point_size_is_fixed(style, item) && "other points have the radius of their item");
    float half = 0.5f * style->point_size;
    if (style->point_sizing == STP_POINTS_PIXELS) {
        // a disk that may fall between pixel centres covers the pixel of its centre
        return (stp_point_radius){.pixels = half < 0.7072f ? 0.2f : half};
    }
    double scale = stp_affine_scale(&item->transform);
    return (stp_point_radius){.units = scale > 0.0 ? (float)((double)half / scale) : 0.0f};
}
