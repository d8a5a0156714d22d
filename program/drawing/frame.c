// SPDX-License-Identifier: MIT
#include "program/drawing/frame.h"

#include "base/core/clock.h"
#include "draw/draw_gl.h"
#include "program/options/tool.h"

#include <assert.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    SETTLE_FRAMES = 150, ///< maximum frames until the splat size settles
    STEADY_FRAMES = 16,  ///< frames in a row with little change after which it has settled
    LOADED_FRAMES = 200, ///< maximum frames while data is loaded
};
static const double settle_ms = 20000.0, steady_change = 0.02;

stp_result frame_maker_create(stp_context* context, stp_store* store, const stp_draw_style* style,
                              frame_maker* maker)
{
    return frame_maker_create_on(context, store, style, FRAME_BACKEND_CPU, maker);
}

static stp_result create_gl(frame_maker* maker)
{
    stp_draw_gl_desc desc = {.get_proc_address = stp_headless_get_proc_address,
                             .user = &maker->headless};
    return stp_draw_gl_create(maker->context, maker->store, &desc, &maker->renderer);
}

stp_result frame_maker_create_in(stp_context* context, stp_store* store,
                                 const stp_draw_style* style, frame_backend backend,
                                 const stp_headless* headless, frame_maker* maker)
{
    *maker = (frame_maker){.context = context,
                           .store = store,
                           .style = *style,
                           .headless = *headless,
                           .uses_gl = true};
    if (backend == FRAME_BACKEND_GL) {
        return create_gl(maker);
    }
    tool_hold_errors();
    stp_result result = create_gl(maker);
    tool_release_errors(false, NULL);
    if (result != STP_OK) {
        stp_notice(context, "%s cannot draw this; using the CPU", maker->headless.device);
        stp_headless_destroy(&maker->headless);
        maker->uses_gl = false;
        result = stp_draw_cpu_create(context, store, &maker->renderer);
    }
    return result;
}

stp_result frame_maker_create_on(stp_context* context, stp_store* store,
                                 const stp_draw_style* style, frame_backend backend,
                                 frame_maker* maker)
{
    *maker = (frame_maker){.context = context, .store = store, .style = *style};
    if (backend != FRAME_BACKEND_CPU) {
        stp_headless_desc desc = {.only_hardware = backend == FRAME_BACKEND_AUTO};
        stp_headless headless;
        const char* fault = stp_headless_create(&desc, &headless);
        if (fault == NULL) {
            return frame_maker_create_in(context, store, style, backend, &headless, maker);
        }
        if (backend == FRAME_BACKEND_GL) {
            tool_error("backend gl: %s; use --backend cpu", fault);
            return STP_ERROR_UNSUPPORTED;
        }
    }
    return stp_draw_cpu_create(context, store, &maker->renderer);
}

void frame_maker_use_splats(frame_maker* maker, int splats)
{
    if (maker->uses_gl) {
        stp_draw_gl_set_splats(maker->renderer, (stp_gl_splats)splats);
    }
}

const char* frame_backend_name(const frame_maker* maker)
{
    return maker->uses_gl ? "gl" : "cpu";
}

stp_result frame_maker_stream(frame_maker* maker)
{
    assert(maker->residency == NULL && "loads on demand already");
    stp_result result =
        stp_residency_create(maker->store, &(stp_residency_desc){0}, &maker->residency);
    while (result == STP_OK && stp_residency_wait(maker->residency)) {
        stp_residency_update(maker->residency, NULL, 0);
    }
    return result;
}

void frame_maker_destroy(frame_maker* maker)
{
    if (maker->renderer != NULL) {
        stp_renderer_destroy(maker->renderer);
    }
    if (maker->uses_gl) {
        stp_headless_destroy(&maker->headless);
    }
    stp_residency_destroy(maker->residency);
    if (maker->context != NULL) {
        stp_draw_list_destroy(maker->context, &maker->list);
    }
    *maker = (frame_maker){0};
}

stp_result frame_do(frame_maker* maker, frame_task task, void* user)
{
    if (maker->residency == NULL) {
        return task(user);
    }
    tool_hold_errors();
    stp_result result = task(user);
    while (result == STP_ERROR_OUT_OF_MEMORY && stp_residency_yield(maker->residency)) {
        result = task(user);
    }
    tool_release_errors(result != STP_OK, NULL);
    return result;
}

/// A picture to be drawn.
typedef struct drawing_task {
    frame_maker* maker;
    const stp_view* view;
    const stp_quality* quality;
    const stp_draw_style* style;
    stp_image* image;
    stp_draw_stats stats;
} drawing_task;

static stp_result draw_once(void* user)
{
    drawing_task* t = user;
    stp_result result = stp_renderer_draw_selected(t->maker->renderer, t->view, t->quality,
                                                   t->style, &t->maker->list, t->image, &t->stats);
    if (result == STP_OK && t->image == NULL) {
        stp_draw_gl_finish_stats(t->maker->renderer, &t->stats);
    }
    return result;
}

static stp_result accumulate_once(void* user)
{
    drawing_task* t = user;
    return stp_renderer_accumulate(t->maker->renderer, t->view, t->quality, t->style,
                                   &t->maker->list, t->image, &t->stats);
}

static void add_gl_figures(const frame_maker* maker, frame_figures* figures)
{
    stp_draw_gl_stats stats = stp_draw_gl_get_stats(maker->renderer);
    figures->on_gl = true;
    figures->prepare_ms = stats.prepare_ms;
    figures->issue_ms = stats.issue_ms;
    figures->read_ms = stats.read_ms;
    figures->uploaded_bytes = stats.uploaded_bytes;
    figures->gl_bytes = stats.resident_bytes;
    figures->missing += stats.missing;
}

static stp_result draw(frame_maker* maker, const stp_view* view, const stp_quality* quality,
                       const stp_draw_style* style, stp_image* image, frame_figures* figures)
{
    drawing_task task = {
        .maker = maker, .view = view, .quality = quality, .style = style, .image = image};
    const stp_draw_stats* stats = &task.stats;
    assert(image == NULL ? maker->uses_gl
                         : image->width == view->width && image->height == view->height);
    double start = stp_clock_ms();
    uint32_t eyes = stp_view_eye_count(view);
    stp_result result = frame_do(maker, draw_once, &task);
    uint32_t missing = 0;
    if (maker->residency != NULL && result == STP_OK && !quality->reference) {
        stp_residency_stats loaded;
        stp_residency_update(maker->residency, maker->list.requests, maker->list.request_count);
        stp_residency_get_stats(maker->residency, &loaded);
        missing = loaded.missing;
    }
    double frame_ms = stp_clock_ms() - start;
    *figures =
        (frame_figures){.cost = stp_draw_frame_cost(style, stats, maker->list.splat_size, frame_ms),
                        .exceeds = stats->exceeds,
                        .left_out = style->left_out,
                        .missing = missing,
                        .select_ms = stats->select_ms,
                        .draw_ms = stats->draw_ms,
                        .shade_ms = stats->shade_ms,
                        .splats = stats->splats,
                        .triangles = stats->triangles,
                        .extra_splats = eyes * maker->list.extra_splats,
                        .nodes = maker->list.node_count,
                        .layers = stats->layers};
    for (size_t i = 0; i < maker->list.count; ++i) {
        figures->clusters += maker->list.items[i].kind == STP_DRAW_MESH ? eyes : 0;
    }
    if (maker->uses_gl) {
        add_gl_figures(maker, figures);
    }
    return result;
}

stp_result frame_draw(frame_maker* maker, const stp_view* view, const stp_quality* quality,
                      stp_image* image, frame_figures* figures)
{
    return draw(maker, view, quality, &maker->style, image, figures);
}

stp_result frame_draw_originals(frame_maker* maker, const stp_view* view,
                                const stp_visibility* visibility, uint32_t side, bool filtered,
                                stp_image* image)
{
    frame_figures figures;
    stp_draw_style style = maker->style;
    const stp_quality whole = {.reference = true, .visibility = visibility};
    style.supersample = side;
    style.pixel_filter = filtered;
    return draw(maker, view, &whole, &style, image, &figures);
}

stp_result frame_draw_loaded(frame_maker* maker, const stp_view* view, const stp_quality* quality,
                             stp_image* image, frame_figures* figures)
{
    stp_result result = frame_draw(maker, view, quality, image, figures);
    // loading may reveal more nodes to load; capped, in case data is evicted and reloaded forever
    for (int i = 0; i < LOADED_FRAMES && result == STP_OK && maker->residency != NULL; ++i) {
        if (!stp_residency_wait(maker->residency)) {
            break;
        }
        int updates = 0;
        do {
            stp_residency_update(maker->residency, maker->list.requests, maker->list.request_count);
            updates += 1;
        } while (updates < LOADED_FRAMES && stp_residency_wait(maker->residency));
        result = frame_draw(maker, view, quality, image, figures);
    }
    return result;
}

stp_result frame_accumulate(frame_maker* maker, const stp_view* view, const stp_quality* quality,
                            uint32_t count, stp_image* image)
{
    assert(count > 1 && "one frame is not accumulated");
    stp_draw_style style = maker->style;
    style.supersample = 2;
    while (style.supersample * style.supersample < count) {
        style.supersample += 1;
    }
    drawing_task task = {
        .maker = maker, .view = view, .quality = quality, .style = &style, .image = image};
    return frame_do(maker, accumulate_once, &task);
}

stp_result frame_settle(frame_maker* maker, const stp_view* view, stp_budget* budget,
                        stp_quality* quality, stp_image* image)
{
    frame_figures figures;
    double start = stp_clock_ms();
    int steady = 0;
    const stp_draw_style whole = maker->style;
    stp_result result = STP_OK;
    quality->splat_size = stp_budget_splat_size(budget);
    for (int i = 0; i < SETTLE_FRAMES && steady < STEADY_FRAMES && result == STP_OK &&
                    stp_clock_ms() - start < settle_ms && !tool_is_interrupted();
         ++i) {
        maker->style = stp_draw_style_without(&whole, stp_budget_left_out(budget));
        maker->style.resolution = stp_budget_resolution(budget);
        result = frame_draw(maker, view, quality, image, &figures);
        if (result == STP_OK) {
            stp_budget_update(budget, &figures.cost);
            float next = stp_budget_splat_size(budget);
            double change = fabs((double)next / (double)quality->splat_size - 1.0);
            bool decided = stp_budget_has_decided(budget);
            steady = change <= steady_change && decided ? steady + 1 : 0;
            quality->splat_size = next;
        }
    }
    maker->style = whole;
    return result;
}

static bool create_image(stp_context* context, stp_residency* residency, uint32_t width,
                         uint32_t height, stp_image* image)
{
    *image = (stp_image){.width = width, .height = height};
    do {
        image->pixels = stp_alloc_array(context, (size_t)width * height, 4);
    } while (image->pixels == NULL && residency != NULL && stp_residency_yield(residency));
    if (image->pixels == NULL) {
        tool_error("out of memory for a picture of %ux%u", width, height);
    }
    return image->pixels != NULL;
}

bool frame_image_create(stp_context* context, uint32_t width, uint32_t height, stp_image* image)
{
    return create_image(context, NULL, width, height, image);
}

bool frame_maker_create_image(frame_maker* maker, uint32_t width, uint32_t height, stp_image* image)
{
    return create_image(maker->context, maker->residency, width, height, image);
}

static json_t* describe_gl(const frame_figures* f)
{
    return f->on_gl ? json_pack("{s:f, s:f, s:f, s:I, s:I, s:I}", "prepare_ms", f->prepare_ms,
                                "issue_ms", f->issue_ms, "read_ms", f->read_ms, "uploaded_bytes",
                                (json_int_t)f->uploaded_bytes, "resident_bytes",
                                (json_int_t)f->gl_bytes, "missing", (json_int_t)f->missing)
                    : json_null();
}

json_t* frame_describe(const frame_figures* f)
{
    const stp_frame_cost* c = &f->cost;
    return json_pack(
        "{s:f, s:f, s:f, s:f, s:f, s:f, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:o}",
        "splat_size", stp_frame_splat_size(c), "resolution", stp_frame_resolution(c), "frame_ms",
        c->milliseconds, "select_ms", f->select_ms, "draw_ms", f->draw_ms, "shade_ms", f->shade_ms,
        "splats", (json_int_t)f->splats, "fragments", (json_int_t)c->fragments, "clusters",
        (json_int_t)f->clusters, "triangles", (json_int_t)f->triangles, "listed_splats",
        (json_int_t)c->splats, "listed_triangles", (json_int_t)c->listed_triangles, "nodes",
        (json_int_t)f->nodes, "draw_calls", (json_int_t)c->draw_calls, "covered_pixels",
        (json_int_t)c->covered_pixels, "layers", (json_int_t)f->layers, "gl", describe_gl(f));
}

/// Name of the renderer's device: the CPU, or the OpenGL device.
static void read_device(const frame_maker* maker, char* name, size_t size)
{
    if (maker->uses_gl) {
        snprintf(name, size, "%s", maker->headless.device);
        return;
    }
    snprintf(name, size, "CPU");
    FILE* file = fopen("/proc/cpuinfo", "r");
    char line[256];
    while (file != NULL && fgets(line, sizeof(line), file) != NULL) {
        const char* colon = strchr(line, ':');
        if (strncmp(line, "model name", 10) == 0 && colon != NULL) {
            snprintf(name, size, "%.*s", (int)strcspn(colon + 2, "\n"), colon + 2);
            break;
        }
    }
    if (file != NULL) {
        fclose(file);
    }
}

json_t* frame_maker_describe(const frame_maker* maker, uint32_t width, uint32_t height)
{
    char device[200];
    read_device(maker, device, sizeof(device));
    return json_pack("{s:s, s:s, s:I, s:I}", "backend", frame_backend_name(maker), "device", device,
                     "width", (json_int_t)width, "height", (json_int_t)height);
}

uint64_t frame_maker_resident_bytes(const frame_maker* maker)
{
    uint64_t bytes = stp_context_live_bytes(maker->context);
    return bytes + (maker->residency == NULL ? stp_store_file_bytes(maker->store) : 0);
}
