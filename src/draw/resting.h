// SPDX-License-Identifier: MIT
//
// A view at rest: whether the picture is still the same, and which of its samples is next.
#pragma once

#include "base/io/hash.h"
#include "draw/draw.h"

/// Zero-initialize it.
typedef struct stp_resting {
    stp_view view;
    stp_hash list;
    stp_draw_style style;
} stp_resting;

/// Stores view, list and style. @return whether they equal those of the previous call
bool stp_resting_continues(stp_resting* resting, const stp_view* view, const stp_draw_list* list,
                           const stp_draw_style* style);

/// Whether two views make the same picture, including sections.
bool stp_resting_is_same_view(const stp_view* a, const stp_view* b);

/// Grid index of the k-th frame's sample among side x side: consecutive samples lie far apart.
uint32_t stp_resting_sample(uint32_t side, uint32_t k);
