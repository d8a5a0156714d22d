// SPDX-License-Identifier: MIT
// A painter as the files of this room see it.
#pragma once

#include "draw/draw_gl.h"
#include "embed/model.h"
#include "select/budget.h"

#include <stipple/paint.h>

struct stp_painter {
    stp_model* model;
    stp_renderer* renderer;
    bool uses_gl;
    atomic_bool stop;
    stp_draw_list list;
    // the frame-time controller, for the budget it was made for; 0: none yet
    stp_budget budget;
    double budget_ms;
    stp_frame_cost pending; ///< of the last picture, whose time OpenGL does not know yet
    bool has_pending;
    stp_view view; ///< of the last picture; width 0: there is none
};

/// What to select and how to draw, of a caller's options.
STP_MUST_USE stp_result stp_painter_read_options(const stp_painter* painter,
                                                 const stp_paint_desc* desc, stp_quality* quality,
                                                 stp_draw_style* style);
