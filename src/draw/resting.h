// SPDX-License-Identifier: MIT
//
// A view that rests: whether what is drawn is still the same, and which of its samples is next.
#pragma once

#include "base/hash.h"
#include "draw/draw.h"

/// All zero at first.
typedef struct stp_resting {
    stp_view view;
    stp_hash list;
    stp_draw_style style;
} stp_resting;

/// @return whether view, list and style are those of the call before; they are remembered
bool stp_resting_continues(stp_resting* resting, const stp_view* view, const stp_draw_list* list,
                           const stp_draw_style* style);

/// Whether two make the same picture: sections and all.
bool stp_resting_is_same_view(const stp_view* a, const stp_view* b);
bool stp_resting_is_same_style(const stp_draw_style* a, const stp_draw_style* b);

/// The place in the grid of side x side samples of the k-th frame: neighbours in time lie far apart.
uint32_t stp_resting_sample(uint32_t side, uint32_t k);
