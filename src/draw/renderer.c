// SPDX-License-Identifier: MIT
#include "draw/renderer.h"

#include <assert.h>

#ifndef NDEBUG
/// Whether ids of items ascend, and their runs are in the list.
static bool is_drawable(const stp_draw_list* list)
{
    bool good = true;
    for (size_t i = 0; i < list->count && good; ++i) {
        const stp_draw_item* item = &list->items[i];
        good =
            (uint64_t)item->first_run + item->run_count <= list->run_count || item->run_count == 0;
        good = good && (i == 0 || item[-1].first_id <= item->first_id);
    }
    return good;
}
#endif

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
    assert(is_drawable(list));
    return renderer->draw(renderer, view, list, style, image, stats);
}

stp_result stp_renderer_draw_selected(stp_renderer* renderer, const stp_view* view,
                                      const stp_quality* quality, const stp_draw_style* style,
                                      stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_result result = renderer->draw_selected(renderer, view, quality, style, list, image, stats);
    assert((result != STP_OK || is_drawable(list)) && "ids ascend over both passes");
    return result;
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
