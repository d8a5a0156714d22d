// SPDX-License-Identifier: MIT
// Internals of a painter.
#pragma once

#include "draw/draw_gl.h"
#include "draw/frame_effects.h"
#include "embed/model_internal.h"

#include <stipple/paint.h>

struct stp_painter {
    stp_model* model;
    stp_renderer* renderer;
    bool uses_gl;
    atomic_bool stopped;   ///< stp_painter_set_stopped
    atomic_bool abandoned; ///< it was set since the picture began; for the renderer: stays true
    stp_draw_list list;
    // frame-time controller, and its budget; 0: none yet
    stp_budget budget;
    double budget_ms;
    // the last picture, while its OpenGL time is still missing
    stp_draw_stats pending;
    stp_draw_style pending_style;
    double pending_ms;
    bool has_pending;
    stp_view view; ///< view of the last picture; width 0: none
    uint8_t* rows; ///< tightly packed pixels, for callers whose rows are farther apart
    size_t row_bytes;
};

/// Selection and drawing parameters from a caller's options.
STP_MUST_USE stp_result stp_painter_read_options(const stp_painter* painter,
                                                 const stp_paint_desc* desc, stp_quality* quality,
                                                 stp_draw_style* style);
