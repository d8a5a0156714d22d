// SPDX-License-Identifier: MIT
// Base of all backends behind draw.h: the first member of each backend's struct.
#pragma once

#include "base/io/hash.h"
#include "draw/draw.h"
#include "draw/enlarge.h"

#include <stdatomic.h>

struct stp_renderer {
    stp_context* context;
    const atomic_bool* stop; ///< stp_renderer_set_stop
    void (*destroy)(stp_renderer* renderer);
    stp_result (*draw)(stp_renderer* renderer, const stp_view* view, const stp_draw_list* list,
                       const stp_draw_style* style, stp_image* image, stp_draw_stats* stats);
    stp_result (*draw_selected)(stp_renderer* renderer, const stp_view* view,
                                const stp_quality* quality, const stp_draw_style* style,
                                stp_draw_list* list, stp_image* image, stp_draw_stats* stats);
    stp_result (*accumulate)(stp_renderer* renderer, const stp_view* view,
                             const stp_quality* quality, const stp_draw_style* style,
                             stp_draw_list* list, stp_image* image, stp_draw_stats* stats);
    const float* (*depth)(const stp_renderer* renderer);
    stp_enlargement enlargement;
};

static inline bool stp_renderer_is_stopped(const stp_renderer* renderer)
{
    return renderer->stop != NULL && atomic_load_explicit(renderer->stop, memory_order_relaxed);
}

/// Checks a view, and that the image (NULL: not wanted) has its size. @return STP_OK or
/// STP_ERROR_ARGUMENT (logged)
STP_MUST_USE stp_result stp_renderer_check_view(const stp_renderer* renderer, const stp_view* view,
                                                const stp_image* image);

// A view at rest: whether the picture is still the same, and which of its samples is next.

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
