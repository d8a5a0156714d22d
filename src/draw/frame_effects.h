// SPDX-License-Identifier: MIT
//
// Effects of a frame for its budget (select/budget.h): their times, and styles without them.
#pragma once

#include "draw/draw.h"
#include "select/budget.h"

/// Splits the time of a frame, for stp_frame_cost. `stats` are those of the frame, after it is
/// finished. Ambient occlusion beside eye-dome lighting counts as free, because they share their
/// passes.
void stp_draw_split_effects(const stp_draw_style* style, const stp_draw_stats* stats,
                            double milliseconds, double effect_ms[STP_EFFECT_COUNT]);

/// What a budget learns from a finished frame that took so many milliseconds.
stp_frame_cost stp_draw_frame_cost(const stp_draw_style* style, const stp_draw_stats* stats,
                                   float splat_size, double milliseconds);

/// A style without some effects: bits as of stp_budget_left_out.
stp_draw_style stp_draw_style_without(const stp_draw_style* style, uint32_t left_out);
