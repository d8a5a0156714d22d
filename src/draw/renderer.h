// SPDX-License-Identifier: MIT
// Base of all backends behind draw.h: the first member of each backend's struct.
#pragma once

#include "draw/draw.h"

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
};

static inline bool stp_renderer_is_stopped(const stp_renderer* renderer)
{
    return renderer->stop != NULL && atomic_load_explicit(renderer->stop, memory_order_relaxed);
}
