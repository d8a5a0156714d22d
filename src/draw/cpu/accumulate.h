// SPDX-License-Identifier: MIT
//
// A picture as the mean of frames, each shifted by a fraction of a pixel. Used for views at rest,
// and to combine supersampling with post-shading effects. Sums are integers, so they do not depend
// on the order of addition.
#pragma once

#include "draw/cpu/cpu.h"

/// Drops the frames so far if they are of another view, list or style.
void stp_cpu_continue_accumulation(stp_cpu_renderer* r, const stp_view* view,
                                   const stp_draw_list* list, const stp_draw_style* style);

/// Allocates the sums; `frames` frames are already in them. @return STP_OK or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cpu_make_accumulation(stp_cpu_renderer* r, uint32_t frames);
/// Adds the picture of the current eye to its sums of `frames` frames so far.
void stp_cpu_add_frame(stp_cpu_renderer* r);
/// Replaces that picture by the mean of all frames, at least one.
void stp_cpu_show_frames(stp_cpu_renderer* r);
void stp_cpu_destroy_accumulation(stp_cpu_renderer* r);
