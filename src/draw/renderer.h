// SPDX-License-Identifier: MIT
// What every backend is behind draw.h: the first member of its own struct.
#pragma once

#include "draw/draw.h"

struct stp_renderer {
    stp_context* context;
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
