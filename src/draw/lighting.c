// SPDX-License-Identifier: MIT
#include "draw/lighting.h"

#include "draw/shaders/light_constants.h"

static stp_vec3 direction(const stp_view_frame* f, const float along[3])
{
    stp_vec3d sum = stp_scaled(f->right, (double)along[0]);
    sum = stp_subd(sum, stp_scaled(f->down, (double)along[1]));
    return stp_to_float(stp_normalized(stp_subd(sum, stp_scaled(f->forward, (double)along[2]))));
}

stp_lighting stp_lighting_make(const stp_view_frame* frame, bool headlight)
{
    static const float shoulder[3] = {-0.45f, 0.65f, 0.62f}, head[3] = {0.0f, 0.0f, 1.0f};
    static const float left[3] = {MIRROR_LEFT_BOX}, right[3] = {MIRROR_RIGHT_BOX};
    return (stp_lighting){.key = direction(frame, headlight ? head : shoulder),
                          .up = {0.0f, 1.0f, 0.0f},
                          .left_box = direction(frame, left),
                          .right_box = direction(frame, right)};
}
