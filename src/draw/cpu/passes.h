// SPDX-License-Identifier: MIT
//
// Samples of a picture, each for all eyes, in one pass or two. With two passes, content occluded in
// the eyes' previous pictures is deferred; the pyramids are then rebuilt from the pictures so far,
// and deferred content that they do not occlude is drawn. One selection serves all eyes; each eye
// has its own pixels, pyramid and occlusion bits.
#pragma once

#include "draw/cpu/cpu.h"

/// Selects the first pass of a two-pass sample, and measures the time. @return as stp_select
STP_MUST_USE stp_result stp_cpu_select_sample(stp_cpu_renderer* r);

/// Draws side * side samples of a picture without effects: shading sums them. @return result of the
/// first failing step
STP_MUST_USE stp_result stp_cpu_draw_summed(stp_cpu_renderer* r, const stp_draw_list* list,
                                            uint32_t side, stp_draw_stats* stats);
/// Draws samples [first, end) as separate pictures, added to the sum.
STP_MUST_USE stp_result stp_cpu_draw_accumulated(stp_cpu_renderer* r, const stp_draw_list* list,
                                                 uint32_t side, uint32_t first, uint32_t end,
                                                 stp_draw_stats* stats);
/// Puts the pictures of two eyes side by side.
void stp_cpu_join_eyes(stp_cpu_renderer* r, stp_image* image);

/// Clears all buffers after a failure.
void stp_cpu_empty_pixels(stp_cpu_renderer* r);
