// SPDX-License-Identifier: MIT
//
// Where light comes from: a key light, a sky above a ground, and two soft boxes that polished surfaces mirror. The sky is the
// scene's, so that its up side is brighter from wherever it is seen; the rest moves with the eye, so that it shows shapes
// from everywhere. How much light: draw/shaders/light_constants.h.
#pragma once

#include "select/view_frame.h"

/// Unit vectors, scene space.
typedef struct stp_lighting {
    stp_vec3 key; ///< towards the key light
    stp_vec3 up;  ///< towards the sky
    stp_vec3 left_box, right_box;
} stp_lighting;

/// @param headlight  the key light is at the eye instead of above the viewer's left shoulder
stp_lighting stp_lighting_make(const stp_view_frame* frame, bool headlight);
