// SPDX-License-Identifier: MIT
#include "draw/recolor.h"

#include <assert.h>

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
