// SPDX-License-Identifier: MIT
//
// Effects of a frame for its budget (select/budget.h): their times, and styles without them.
#pragma once

#include "draw/draw.h"
#include "select/budget.h"

/// What a budget learns from a frame that took so many milliseconds. `style` is that of the frame,
/// `stats` are final. Ambient occlusion beside eye-dome lighting counts as free, because they share
/// their passes. Where a style wants the nearest layer of transparent surfaces, it counts as free,
/// too, because it is not left out.
stp_frame_cost stp_draw_frame_cost(const stp_draw_style* style, const stp_draw_stats* stats,
                                   float splat_size, double milliseconds);

/// A style without some effects: bits as of stp_budget_left_out. Layers of transparent surfaces are
/// reduced to the nearest one, and that to a pattern of pixels; a style that wants one of these keeps
/// it.
stp_draw_style stp_draw_style_without(const stp_draw_style* style, uint32_t left_out);
