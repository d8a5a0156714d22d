// SPDX-License-Identifier: MIT
#include "draw/renderer.h"

#include "select/eyes.h"

#include <assert.h>

enum { SIDE_LIMIT = 65536 };

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

stp_result stp_renderer_check_view(const stp_renderer* renderer, const stp_view* view,
                                   const stp_image* image)
{
    stp_result result = stp_view_check(renderer->context, view);
    if (result == STP_OK && image != NULL &&
        (image->width != view->width || image->height != view->height)) {
        return stp_fail(renderer->context, STP_ERROR_ARGUMENT,
                        "view: its size is %u x %u, that of the image %u x %u", view->width,
                        view->height, image->width, image->height);
    }
    if (result == STP_OK && (view->width > SIDE_LIMIT || view->height > SIDE_LIMIT ||
                             (uint64_t)view->width * view->height > UINT32_MAX / 4)) {
        return stp_fail(renderer->context, STP_ERROR_ARGUMENT,
                        "view: %u x %u pixels are more than the limit of %d on a side and 2^30 in "
                        "all",
                        view->width, view->height, SIDE_LIMIT);
    }
    return result;
}

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
