// SPDX-License-Identifier: MIT
#include "draw/lighting.h"

#include "draw/shaders/light_constants.h"

#include <assert.h>

static stp_vec3 direction(const stp_view_frame* f, const float along[3])
{
    return stp_to_float(stp_normalized(stp_view_frame_direction(f, along)));
}

#ifndef NDEBUG
static bool is_unit(stp_vec3 v)
{
    return fabsf(stp_dot(v, v) - 1.0f) < 1e-4f;
}
#endif

stp_lighting stp_lighting_make(const stp_view_frame* frame, bool headlight)
{
    static const float head[3] = {0.0f, 0.0f, 1.0f};
    static const float left[3] = {MIRROR_LEFT_BOX}, right[3] = {MIRROR_RIGHT_BOX};
    stp_lighting made = {.key = direction(frame, headlight ? head : stp_key_light),
                         .up = {0.0f, 1.0f, 0.0f},
                         .left_box = direction(frame, left),
                         .right_box = direction(frame, right)};
    assert(is_unit(made.key) && is_unit(made.left_box) && is_unit(made.right_box));
    return made;
}
