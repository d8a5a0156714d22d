// SPDX-License-Identifier: MIT
//
// A picture as the mean of frames, each shifted by a part of a pixel: what a view that rests becomes, and how
// supersampling goes together with what is done after shading. Sums are of whole numbers: they do not depend on who adds.
#pragma once

#include "draw/cpu/cpu.h"

/// Forgets the frames so far where they are of another view, list or style.
void cpu_continue_accumulation(cpu_renderer* r, const stp_view* view, const stp_draw_list* list,
                               const stp_draw_style* style);

/// Room for the sums, of which there are `frames`. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result cpu_make_accumulation(cpu_renderer* r, uint32_t frames);
/// Adds the picture of the eye that is drawn to its sums, of which there are `frames` so far.
void cpu_add_frame(cpu_renderer* r);
/// Makes that picture the mean of all frames, of which there is one at least.
void cpu_show_frames(cpu_renderer* r);
void cpu_destroy_accumulation(cpu_renderer* r);
