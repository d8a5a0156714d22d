// SPDX-License-Identifier: MIT
#include "draw/shading_setup.h"

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

stp_draw_heights stp_draw_heights_make(const stp_view_frame* frame, const stp_draw_pixels* pixels,
                                       const stp_draw_style* style)
{
    assert(frame->scale > 0.0 && "a valid frame");
    double low = style->elevation[0], range = style->elevation[1] - low;
    double unit = range > 0.0 ? 1.0 / range : 0.0;
    double x = frame->center_x + pixels->shift_x, y = frame->center_y + pixels->shift_y;
    double across = frame->right.y / frame->scale * unit,
           down = frame->down.y / frame->scale * unit;
    double start = -(across * x + down * y);
    stp_draw_heights h = {.place = {(float)((frame->eye.y - low) * unit), 0.0f, 0.0f},
                          .along = {(float)(frame->forward.y * unit), 0.0f, 0.0f},
                          .nearness_scale = (float)pixels->nearness_scale,
                          .nearness_offset = (float)pixels->nearness_offset,
                          .parallel = frame->parallel};
    float* sides = frame->parallel ? h.place : h.along;
    double first = frame->parallel ? (frame->eye.y - low) * unit : frame->forward.y * unit;
    sides[0] = (float)(first + start);
    sides[1] = (float)across;
    sides[2] = (float)down;
    return h;
}
