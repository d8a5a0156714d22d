// SPDX-License-Identifier: MIT
//
// Colours that pixels have instead of their surfaces': of their height in the scene, on an even scale (base/color_map.h), or of their
// normal. Both backends work them out when a pixel is shaded (src/draw/shaders/lib_recolor.glsl), so they are the same for triangles,
// splats and points.
#pragma once

#include "draw/draw.h"
#include "select/view_frame.h"

/// The part of the way from the lowest to the highest height, for a pixel of the picture and the depth along the gaze:
/// place . (1, x, y) + depth * along . (1, x, y).
typedef struct stp_draw_heights {
    float place[3], along[3];
    float nearness_scale, nearness_offset;
    bool parallel;
} stp_draw_heights;

/// How pixels are placed (draw/placement.h).
typedef struct stp_draw_pixels {
    double shift_x, shift_y;
    double nearness_scale, nearness_offset;
} stp_draw_pixels;

stp_draw_heights stp_draw_heights_make(const stp_view_frame* frame, const stp_draw_pixels* pixels,
                                       const stp_draw_style* style);

/// The place on the even scale of a pixel whose middle is (x, y), of true nearness above 0.
static inline uint32_t stp_draw_height_place(const stp_draw_heights* h, float x, float y,
                                             float nearness)
{
    float depth = h->parallel ? (nearness - h->nearness_offset) / h->nearness_scale
                              : h->nearness_scale / nearness;
    float part = (h->place[0] + h->place[1] * x + h->place[2] * y) +
                 depth * (h->along[0] + h->along[1] * x + h->along[2] * y);
    return part > 0.0f ? (part < 1.0f ? (uint32_t)(part * 255.0f + 0.5f) : 255) : 0;
}
