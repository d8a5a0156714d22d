// SPDX-License-Identifier: MIT
//
// Draws pictures of a model: selects, draws, and feeds measurements back. While the model streams,
// each picture reports the data it wanted; memory that a picture needs takes precedence over loaded
// data.
#include "base/core/clock.h"
#include "embed/painter_internal.h"
#include "select/view_frame.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { COMPLETE_PICTURES = 200 }; // maximum passes while a view's data is loaded

/// A picture to be drawn.
typedef struct picture {
    stp_painter* painter;
    const stp_view* view;
    stp_quality quality;
    stp_draw_style style;
    stp_image* image;
    bool accumulates, complete;
    double frame_ms;
    double refused_ms, refused_draw_ms; ///< before it: a picture that was given up
    stp_draw_stats stats;
    uint32_t missing, coming;
} picture;

static stp_result create_renderer(stp_painter* painter, const stp_painter_desc* desc)
{
    stp_model* model = painter->model;
    painter->uses_gl = desc->get_proc_address != NULL;
    if (!painter->uses_gl) {
        return stp_draw_cpu_create(model->context, model->store, &painter->renderer);
    }
    stp_draw_gl_desc gl = {.get_proc_address = desc->get_proc_address,
                           .user = desc->gl_user,
                           .memory_bytes = desc->gl_memory_bytes,
                           .upload_bytes = desc->gl_upload_bytes,
                           .debug = desc->gl_debug};
    return stp_draw_gl_create(model->context, model->store, &gl, &painter->renderer);
}

stp_result stp_painter_create(stp_model* model, const stp_painter_desc* given,
                              stp_painter** painter)
{
    stp_painter_desc desc;
    stp_result result = STP_CHECK_CALL(model, painter);
    if (result != STP_OK) {
        return result;
    }
    *painter = NULL;
    result = STP_READ_DESC(model->context, stp_painter_desc, &desc, given);
    if (result != STP_OK) {
        return result;
    }
    stp_painter* made = STP_NEW_ZEROED(model->context, stp_painter, 1);
    if (made == NULL) {
        return stp_fail_memory(model->context);
    }
    made->model = model;
    atomic_init(&made->stopped, false);
    atomic_init(&made->abandoned, false);
    result = create_renderer(made, &desc);
    if (result != STP_OK) {
        made->renderer = NULL;
        stp_painter_destroy(made);
        return result;
    }
    if (desc.can_stop) {
        stp_renderer_set_stop(made->renderer, &made->abandoned);
    }
    *painter = made;
    return STP_OK;
}

void stp_painter_destroy(stp_painter* painter)
{
    if (painter == NULL) {
        return;
    }
    stp_context* context = painter->model->context;
    if (painter->renderer != NULL) {
        stp_renderer_destroy(painter->renderer);
    }
    stp_draw_list_destroy(context, &painter->list);
    stp_free(context, painter->rows);
    stp_free(context, painter);
}

/// Collects OpenGL's measurements of the previous picture, which is finished by now.
static void update_budget_pending(stp_painter* painter)
{
    stp_draw_stats* stats = &painter->pending;
    if (!painter->has_pending) {
        return;
    }
    painter->has_pending = false;
    stp_draw_gl_finish_stats(painter->renderer, stats);
    stp_frame_cost cost =
        stp_draw_frame_cost(&painter->pending_style, stats, painter->list.splat_size,
                            painter->pending_ms + stats->draw_ms + stats->shade_ms);
    stp_budget_update(&painter->budget, &cost);
}

static void prepare_budget(stp_painter* painter, double budget_ms)
{
    if (!(budget_ms > 0.0)) {
        painter->has_pending = false;
        return;
    }
    if (painter->budget_ms != budget_ms) {
        stp_budget_init(&painter->budget, STP_CONTROLLER_PREDICT, budget_ms);
        if (!painter->uses_gl) {
            stp_budget_lower_resolution(&painter->budget);
        }
        painter->budget_ms = budget_ms;
        painter->has_pending = false;
    }
    update_budget_pending(painter);
}

/// Splat size for a budget, at least the requested one, in pixels of the whole picture.
static float choose_size(const stp_painter* painter, double budget_ms, float minimum)
{
    const stp_budget* budget = &painter->budget;
    return budget_ms > 0.0
               ? stp_max(stp_budget_splat_size(budget) / stp_budget_resolution(budget), minimum)
               : minimum;
}

static void update_budget(stp_painter* painter, const picture* p)
{
    assert(!painter->has_pending && "the previous picture's cost would be lost");
    if (painter->uses_gl && p->image == NULL) { // the GPU is still working
        painter->pending = p->stats;
        painter->pending_style = p->style;
        painter->pending_ms = p->frame_ms;
        painter->has_pending = true;
    } else {
        stp_frame_cost cost =
            stp_draw_frame_cost(&p->style, &p->stats, painter->list.splat_size, p->frame_ms);
        cost.milliseconds += p->refused_ms;
        stp_budget_update(&painter->budget, &cost);
    }
}

static stp_result draw_once(picture* p)
{
    stp_painter* painter = p->painter;
    return p->accumulates
               ? stp_renderer_accumulate(painter->renderer, p->view, &p->quality, &p->style,
                                         &painter->list, p->image, &p->stats)
               : stp_renderer_draw_selected(painter->renderer, p->view, &p->quality, &p->style,
                                            &painter->list, p->image, &p->stats);
}

/// Draws; if out of memory, evicts loaded data and tries again. Several threads may fail: the first
/// error is logged.
static stp_result draw_yielding(picture* p)
{
    stp_context* context = p->painter->model->context;
    stp_residency* residency = p->painter->model->residency;
    stp_hold_errors(context);
    stp_result result = draw_once(p);
    while (result == STP_ERROR_OUT_OF_MEMORY && residency != NULL &&
           stp_residency_yield(residency)) {
        stp_hold_errors(context);
        result = draw_once(p);
    }
    stp_release_errors(context, result != STP_OK);
    return result;
}

/// Draws, requests data that was missing, and counts it.
static stp_result draw_and_request(picture* p)
{
    stp_painter* painter = p->painter;
    stp_residency* residency = painter->model->residency;
    double start = stp_clock_ms();
    stp_result result = draw_yielding(p);
    p->missing = p->coming = 0;
    if (result == STP_OK && residency != NULL) {
        stp_residency_stats stats;
        stp_residency_update(residency, painter->list.requests, painter->list.request_count);
        stp_residency_get_stats(residency, &stats);
        p->missing = stats.missing;
        p->coming = stats.loading;
    }
    if (result == STP_OK && painter->uses_gl) {
        stp_draw_gl_stats stats = stp_draw_gl_get_stats(painter->renderer);
        p->missing += stats.missing;
        p->coming += stats.coming;
    }
    p->frame_ms = stp_clock_ms() - start;
    return result;
}

/// Draws; with `complete`, again until no more data arrives. New data may allow nodes to be opened
/// whose content is then wanted. This ends, but a limit guards against waiting forever.
static stp_result draw_complete(picture* p)
{
    stp_painter* painter = p->painter;
    stp_residency* residency = painter->model->residency;
    stp_result result = draw_and_request(p);
    for (int i = 0; i < COMPLETE_PICTURES && result == STP_OK && p->complete; ++i) {
        int updates = 0;
        while (residency != NULL && updates < COMPLETE_PICTURES && stp_residency_wait(residency)) {
            stp_residency_update(residency, painter->list.requests, painter->list.request_count);
            updates += 1;
        }
        bool uploads = painter->uses_gl && stp_draw_gl_get_stats(painter->renderer).coming > 0;
        if (updates == 0 && !uploads) {
            break;
        }
        result = draw_and_request(p);
    }
    return result;
}

static void report_picture(const picture* p, stp_paint_report* report)
{
    float resolution = stp_draw_resolution(&p->style);
    stp_paint_report made = {.frame_ms = p->frame_ms + p->refused_ms,
                             .select_ms = p->stats.select_ms + p->refused_ms - p->refused_draw_ms,
                             .draw_ms = p->stats.draw_ms + p->refused_draw_ms,
                             .shade_ms = p->stats.shade_ms,
                             .splat_size = p->painter->list.splat_size / resolution,
                             .splat_count = p->stats.splats,
                             .triangle_count = p->stats.triangles,
                             .covered_pixels = p->stats.covered_pixels,
                             .samples = p->stats.samples,
                             .missing = p->missing,
                             .coming = p->coming,
                             .resolution = resolution};
    STP_WRITE_INFO(report, made);
}

/// Makes `tight` an image of the painter's own memory, tightly packed, of the same size as `image`.
static stp_result reserve_rows(stp_painter* painter, const stp_image* image, stp_image* tight)
{
    stp_context* context = painter->model->context;
    size_t bytes = (size_t)image->width * image->height * 4;
    if (painter->row_bytes != bytes) {
        stp_free(context, painter->rows);
        painter->row_bytes = 0;
        painter->rows = stp_alloc(context, bytes);
        if (painter->rows == NULL) {
            return stp_fail_memory(context);
        }
        painter->row_bytes = bytes;
    }
    assert(painter->row_bytes == bytes && bytes > 0);
    *tight = (stp_image){image->width, image->height, painter->rows};
    return STP_OK;
}

static void copy_rows(const stp_image* tight, const stp_image* image, size_t stride)
{
    size_t bytes = (size_t)tight->width * 4;
    assert(stride >= bytes && tight->width == image->width && tight->height == image->height);
    for (uint32_t y = 0; y < tight->height; ++y) {
        memcpy(image->pixels + y * stride, tight->pixels + y * bytes, bytes);
    }
}

/// Draws into the caller's pixels, whose rows are `stride` bytes apart.
static stp_result draw_rows(picture* p, size_t stride)
{
    stp_image* image = p->image;
    size_t bytes = image != NULL ? (size_t)image->width * 4 : 0;
    if (image == NULL || stride == 0 || stride == bytes) {
        return draw_complete(p);
    }
    bool fits = image->width == p->view->width && image->height == p->view->height;
    if (stride < bytes || !fits || bytes == 0 || image->height == 0) {
        return stp_fail(p->painter->model->context, STP_ERROR_ARGUMENT,
                        "stp_painter_draw: rows are shorter than the picture, or of another size");
    }
    stp_image tight;
    stp_result result = reserve_rows(p->painter, image, &tight);
    if (result != STP_OK) {
        return result;
    }
    p->image = &tight;
    result = draw_complete(p);
    p->image = image;
    if (result == STP_OK && !p->stats.exceeds) {
        copy_rows(&tight, image, stride);
    }
    return result;
}

/// Draws within the budget. A picture whose list is too long is not drawn before it is coarser.
static stp_result draw_in_time(picture* p, size_t stride)
{
    stp_painter* painter = p->painter;
    stp_budget* budget = &painter->budget;
    const stp_draw_style whole = p->style;
    const float minimum = p->quality.splat_size;
    p->quality.limit = p->complete ? (stp_work_limit){0} : stp_budget_limit(budget);
    stp_result result;
    for (;;) {
        float resolution = stp_budget_resolution(budget);
        p->quality.splat_size = resolution * choose_size(painter, painter->budget_ms, minimum);
        p->style = stp_draw_style_without(&whole, stp_budget_left_out(budget));
        p->style.resolution = resolution;
        result = draw_rows(p, stride);
        if (result != STP_OK || !p->stats.exceeds) {
            break;
        }
        stp_frame_cost listed =
            stp_draw_frame_cost(&p->style, &p->stats, painter->list.splat_size, p->frame_ms);
        stp_budget_foresee(budget, &listed);
        p->refused_ms = p->frame_ms;
        p->refused_draw_ms = p->stats.draw_ms;
        p->quality.limit = (stp_work_limit){0};
    }
    return result;
}

/// A picture that was stopped stays so, even if the host takes it back at once: parts are missing.
/// In this order no call of stp_painter_set_stopped is lost.
static void begin_stopping(stp_painter* painter)
{
    atomic_store(&painter->abandoned, false);
    if (atomic_load(&painter->stopped)) {
        atomic_store(&painter->abandoned, true);
    }
}

stp_result stp_painter_draw(stp_painter* painter, const stp_view* view, const stp_paint_desc* given,
                            stp_image* image, stp_paint_report* report)
{
    stp_paint_desc desc;
    if (painter == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    stp_context* context = painter->model->context;
    picture p = {.painter = painter, .view = view, .image = image};
    stp_result result = STP_READ_DESC(context, stp_paint_desc, &desc, given);
    result = result == STP_OK ? STP_CHECK_POINTER(context, view) : result;
    if (result == STP_OK) {
        result = stp_painter_read_options(painter, &desc, &p.quality, &p.style);
    }
    if (result != STP_OK) {
        return result;
    }
    if (image == NULL ? !painter->uses_gl : image->pixels == NULL) {
        return stp_fail(context, STP_ERROR_ARGUMENT, "stp_painter_draw: no pixels to draw");
    }
    p.accumulates = desc.accumulate;
    p.complete = desc.complete;
    prepare_budget(painter, desc.budget_ms);
    bool budgeted = desc.budget_ms > 0.0 && !p.accumulates;
    painter->view.width = 0;
    begin_stopping(painter);
    if (budgeted) {
        result = draw_in_time(&p, desc.stride);
    } else {
        p.quality.splat_size = choose_size(painter, desc.budget_ms, p.quality.splat_size);
        result = draw_rows(&p, desc.stride);
    }
    if (result != STP_OK) {
        return result;
    }
    painter->view = *view;
    if (budgeted) {
        update_budget(painter, &p);
    }
    if (report != NULL) {
        report_picture(&p, report);
    }
    return STP_OK;
}

uint32_t stp_painter_get_texture(const stp_painter* painter)
{
    bool has_texture = painter != NULL && painter->uses_gl && painter->view.width > 0;
    return has_texture ? stp_draw_gl_texture(painter->renderer) : 0;
}

stp_result stp_painter_get_depths(stp_painter* painter, float* depths, size_t count)
{
    if (painter == NULL) {
        return STP_ERROR_ARGUMENT;
    }
    stp_context* context = painter->model->context;
    const stp_view* view = &painter->view;
    stp_view_frame frame;
    stp_result result = STP_CHECK_POINTER(context, depths);
    if (result != STP_OK) {
        return result;
    }
    bool fits = view->width > 0 && count == (size_t)view->width * view->height &&
                stp_view_frame_make(view, &frame) && !frame.parallel;
    if (!fits) {
        return stp_fail(context, STP_ERROR_ARGUMENT,
                        "stp_painter_get_depths: the last picture must have %zu pixels, one eye "
                        "and a perspective projection",
                        count);
    }
    const float* nearness = stp_renderer_depth(painter->renderer);
    if (nearness == NULL) {
        return stp_fail_memory(context);
    }
    float near_distance = (float)frame.near_distance;
    for (size_t i = 0; i < count; ++i) {
        depths[i] = nearness[i] > 0.0f ? near_distance / nearness[i] : INFINITY;
    }
    return STP_OK;
}

void stp_painter_set_stopped(stp_painter* painter, bool stopped)
{
    if (painter != NULL) {
        atomic_store(&painter->stopped, stopped);
        if (stopped) {
            atomic_store(&painter->abandoned, true);
        }
    }
}
