// SPDX-License-Identifier: MIT
//
// Light directions: a key light, a sky above a ground, and two soft boxes that polished surfaces
// reflect. The sky is fixed to the scene, so its upper sides are brighter from any viewpoint; the
// rest moves with the eye, to show shapes from everywhere. Intensities:
// draw/shaders/light_constants.h.
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
