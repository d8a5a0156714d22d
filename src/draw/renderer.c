// SPDX-License-Identifier: MIT
#include "draw/renderer.h"

void stp_renderer_destroy(stp_renderer* renderer)
{
    if (renderer != NULL) {
        renderer->destroy(renderer);
    }
}

stp_result stp_renderer_draw(stp_renderer* renderer, const stp_view* view,
                             const stp_draw_list* list, const stp_draw_style* style,
                             stp_image* image, stp_draw_stats* stats)
{
    return renderer->draw(renderer, view, list, style, image, stats);
}

stp_result stp_renderer_draw_selected(stp_renderer* renderer, const stp_view* view,
                                      const stp_quality* quality, const stp_draw_style* style,
                                      stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    return renderer->draw_selected(renderer, view, quality, style, list, image, stats);
}

stp_result stp_renderer_accumulate(stp_renderer* renderer, const stp_view* view,
                                   const stp_quality* quality, const stp_draw_style* style,
                                   stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    return renderer->accumulate(renderer, view, quality, style, list, image, stats);
}

void stp_renderer_set_stop(stp_renderer* renderer, const atomic_bool* stop)
{
    renderer->stop = stop;
}

const float* stp_renderer_depth(const stp_renderer* renderer)
{
    return renderer->depth(renderer);
}
