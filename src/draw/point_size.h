// SPDX-License-Identifier: MIT
// Points of a fixed size: which items have it, and how large they are. Such a point is a disk that faces the eye, drawn whole.
#pragma once

#include "draw/draw.h"

/// How far the rim of a point lies behind its centre, in radii: of points that overlap, a pixel shows the one with the nearest
/// centre.
#define STP_POINT_RIM_DEPTH 1.0f

/// The radius of each point of an item: one of both is 0.
typedef struct stp_point_radius {
    float units;  ///< of the item's space
    float pixels; ///< on the screen
} stp_point_radius;

static inline bool stp_point_size_is_fixed(const stp_draw_style* style, const stp_draw_item* item)
{
    return style->point_sizing != STP_POINTS_ADAPTIVE && item->of_points;
}

static inline stp_point_radius stp_point_radius_of(const stp_draw_style* style,
                                                   const stp_draw_item* item)
{
    float half = 0.5f * style->point_size;
    if (style->point_sizing == STP_POINTS_PIXELS) {
        // a disk that may lie between the middles of pixels is the pixel of its centre
        return (stp_point_radius){.pixels = half < 0.7072f ? 0.2f : half};
    }
    double scale = stp_affine_scale(&item->transform);
    return (stp_point_radius){.units = scale > 0.0 ? (float)((double)half / scale) : 0.0f};
}
