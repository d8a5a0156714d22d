// SPDX-License-Identifier: MIT
#include "draw/renderer.h"

#include "base/core/clock.h"
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
        stp_enlargement_destroy(renderer->context, &renderer->enlargement);
        renderer->destroy(renderer);
    }
}

stp_result stp_renderer_draw(stp_renderer* renderer, const stp_view* view,
                             const stp_draw_list* list, const stp_draw_style* style,
                             stp_image* image, stp_draw_stats* stats)
{
    assert(is_drawable(list));
    renderer->enlargement.is_used = false;
    return renderer->draw(renderer, view, list, style, image, stats);
}

/// Draws at the style's resolution, and enlarges.
static stp_result draw_enlarged(stp_renderer* renderer, const stp_view* view,
                                const stp_quality* quality, const stp_draw_style* style,
                                stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_enlargement* e = &renderer->enlargement;
    stp_image small_image;
    stp_result result = stp_renderer_check_view(renderer, view, image);
    if (result != STP_OK) {
        return result;
    }
    stp_view small = stp_enlarge_view(view, (double)style->resolution);
    stp_draw_style smaller = *style;
    smaller.point_size *= style->point_sizing == STP_POINTS_PIXELS ? style->resolution : 1.0f;
    result = stp_enlarge_begin(renderer->context, &small, e, &small_image);
    if (result == STP_OK) {
        result =
            renderer->draw_selected(renderer, &small, quality, &smaller, list, &small_image, stats);
    }
    if (result != STP_OK || stats->exceeds) {
        return result;
    }
    double start = stp_clock_ms();
    result =
        stp_enlarge_picture(renderer->context, e, &small_image, stp_view_eye_count(view), image);
    stats->shade_ms += stp_clock_ms() - start;
    e->is_used = result == STP_OK;
    e->has_nearness = false;
    e->small = small;
    e->view = *view;
    return result;
}

stp_result stp_renderer_draw_selected(stp_renderer* renderer, const stp_view* view,
                                      const stp_quality* quality, const stp_draw_style* style,
                                      stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    bool enlarges = image != NULL && stp_draw_resolution(style) < 1.0f;
    renderer->enlargement.is_used = false;
    stp_result result = (enlarges ? draw_enlarged : renderer->draw_selected)(
        renderer, view, quality, style, list, image, stats);
    assert((result != STP_OK || is_drawable(list)) && "ids ascend over both passes");
    return result;
}

stp_result stp_renderer_accumulate(stp_renderer* renderer, const stp_view* view,
                                   const stp_quality* quality, const stp_draw_style* style,
                                   stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    renderer->enlargement.is_used = false;
    return renderer->accumulate(renderer, view, quality, style, list, image, stats);
}

void stp_renderer_set_stop(stp_renderer* renderer, const atomic_bool* stop)
{
    renderer->stop = stop;
}

const float* stp_renderer_depth(stp_renderer* renderer)
{
    stp_enlargement* e = &renderer->enlargement;
    const float* nearness = renderer->depth(renderer);
    if (!e->is_used || nearness == NULL) {
        return nearness;
    }
    if (!e->has_nearness) {
        nearness = stp_enlarge_nearness(renderer->context, e, &e->small, nearness, &e->view);
        e->has_nearness = nearness != NULL;
        return nearness;
    }
    return e->nearness;
}
