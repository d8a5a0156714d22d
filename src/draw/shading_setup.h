// SPDX-License-Identifier: MIT
// What the shading of all backends needs for a picture: the directions of lights, and colours that
// replace surface colours.
#pragma once

#include "draw/draw.h"
#include "select/view_frame.h"

// Light directions: a key light, a sky above a ground, and two soft boxes that polished surfaces
// reflect. The sky is fixed to the scene, so its upper sides are brighter from any viewpoint; the
// rest moves with the eye, to show shapes from everywhere. Intensities:
// draw/shaders/light_constants.h.

/// Unit vectors, scene space.
typedef struct stp_lighting {
    stp_vec3 key; ///< towards the key light
    stp_vec3 up;  ///< towards the sky
    stp_vec3 left_box, right_box;
} stp_lighting;

/// @param headlight  the key light is at the eye instead of above the viewer's left shoulder
stp_lighting stp_lighting_make(const stp_view_frame* frame, bool headlight);

// Colours that replace surface colours: by height in the scene, on a perceptually uniform scale
// (base/math/color.h), or by normal. Both backends compute them when shading a pixel
// (src/draw/shaders/lib_recolor.glsl), so they are the same for triangles, splats and points.

/// Relative height, from 0 at the lowest to 1 at the highest, for a pixel and its depth: place .
/// (1, x, y) + depth * along . (1, x, y).
typedef struct stp_draw_heights {
    float place[3], along[3];
    float nearness_scale, nearness_offset;
    bool parallel;
} stp_draw_heights;

/// Placement of pixels (draw/placement.h).
typedef struct stp_draw_pixels {
    double shift_x, shift_y;
    double nearness_scale, nearness_offset;
} stp_draw_pixels;

stp_draw_heights stp_draw_heights_make(const stp_view_frame* frame, const stp_draw_pixels* pixels,
                                       const stp_draw_style* style);

/// Scale index of a pixel with centre (x, y) and true nearness above 0.
static inline uint32_t stp_draw_height_place(const stp_draw_heights* h, float x, float y,
                                             float nearness)
{
    float depth = h->parallel ? (nearness - h->nearness_offset) / h->nearness_scale
                              : h->nearness_scale / nearness;
    float part = (h->place[0] + h->place[1] * x + h->place[2] * y) +
                 depth * (h->along[0] + h->along[1] * x + h->along[2] * y);
    return part > 0.0f ? (part < 1.0f ? (uint32_t)(part * 255.0f + 0.5f) : 255) : 0;
}
