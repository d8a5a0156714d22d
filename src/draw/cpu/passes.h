// SPDX-License-Identifier: MIT
//
// Samples of a picture, each for all eyes, in one pass or in two: what the eyes' pictures before hid is set aside; then the
// pictures so far become pyramids, and of what was set aside that is drawn which they do not hide. One selection serves
// all eyes; each has its own pixels, pyramid, and bits of what was hidden from it.
#pragma once

#include "draw/cpu/cpu.h"

/// Selects the first pass of a sample in two passes, timed. @return as stp_select
STP_MUST_USE stp_result cpu_select_sample(cpu_renderer* r);

/// Draws side * side samples of a picture without effects: shading sums them. @return as what is called
STP_MUST_USE stp_result cpu_draw_summed(cpu_renderer* r, const stp_draw_list* list, uint32_t side,
                                        stp_draw_stats* stats);
/// Draws samples [first, end) as pictures of their own, added to the sum.
STP_MUST_USE stp_result cpu_draw_accumulated(cpu_renderer* r, const stp_draw_list* list,
                                             uint32_t side, uint32_t first, uint32_t end,
                                             stp_draw_stats* stats);
/// Puts the pictures of two eyes side by side.
void cpu_join_eyes(cpu_renderer* r, stp_image* image);

/// Empties all buffers, after a failure.
void cpu_empty_pixels(cpu_renderer* r);
