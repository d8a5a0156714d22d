// SPDX-License-Identifier: MIT
// Draws a frame.
#include "draw/gl/gl_renderer.h"

#include "base/core/clock.h"
#include "base/core/context.h"
#include "draw/gl/upload.h"
#include "select/eyes.h"

#include <assert.h>
#include <stdio.h>
#include <string.h>

enum {
    SUPERSAMPLE_LIMIT = 64,
    SCENE_TO_FILE = 3, ///< bytes in the pool over those of the file, which is coded: at most about
    TEXEL_SIZE = 4,
};
static const uint64_t default_memory = UINT64_C(1) << 30;
static const uint64_t band_bytes = UINT64_C(1) << 30; // OpenGL's counts per call have 31 bits

static void destroy_programs(stp_gl_renderer* r)
{
    if (r->program_pages > 0) {
        stp_gl_splat_pass_destroy(r);
        stp_gl_raster_pass_destroy(r);
        stp_gl_filter_pass_destroy(r);
        stp_gl_occlusion_pass_destroy(r);
        stp_gl_triangle_pass_destroy(r);
        stp_gl_shade_pass_destroy(r);
        stp_gl_layer_pass_destroy_programs(r);
    }
    r->program_pages = 0;
}

static void destroy(stp_renderer* renderer)
{
    stp_gl_renderer* r = (stp_gl_renderer*)renderer;
    stp_context* context = renderer->context;
    if (r->pool.gl != NULL) { // the context's functions are known
        destroy_programs(r);
        stp_gl_timer_destroy(&r->gl, &r->timer);
        stp_gl_target_destroy(r);
        stp_gl_frame_destroy(r);
        stp_gl_effect_pass_destroy(r);
        stp_gl_pixel_filter_pass_destroy(r);
        stp_gl_cap_pass_destroy(r);
        stp_gl_layer_pass_destroy(r);
        stp_gl_pool_destroy(&r->pool);
        stp_gl_conversions_destroy(r->base.context, &r->conversions);
        const GLuint buffers[] = {r->light_materials, r->materials};
        r->gl.DeleteBuffers(2, buffers);
        if (r->debug != NULL) {
            r->gl.DebugMessageCallback(NULL, NULL);
        }
    }
    stp_gl_entries_destroy(r);
    if (r->readback != NULL) {
        stp_free(context, r->readback->depth);
    }
    stp_free(context, r->readback);
    stp_free(context, r->debug);
    stp_free(context, r);
}

/// Programs support at least the current number of pages: most pools have one.
stp_result stp_gl_make_programs(stp_gl_renderer* r)
{
    uint32_t pages = 1;
    while (pages < r->pool.page_count) {
        pages *= 2;
    }
    assert(pages >= r->pool.page_count && pages <= POOL_PAGES_MAX);
    bool squares = r->style->splat_shape == STP_SPLAT_SQUARE && r->style->filter == STP_FILTER_NONE;
    if (pages == r->program_pages && squares == r->program_squares) {
        return STP_OK;
    }
    destroy_programs(r);
    r->program_pages = pages;
    r->program_squares = squares;
    stp_result result = stp_gl_splat_pass_create(r);
    result = result == STP_OK ? stp_gl_raster_pass_create(r) : result;
    result = result == STP_OK ? stp_gl_triangle_pass_create(r) : result;
    result = result == STP_OK ? stp_gl_shade_pass_create(r) : result;
    if (result != STP_OK) {
        destroy_programs(r);
    }
    return result;
}

/// Errors since the last call: a lost context, or an error reported by a debug context.
static stp_result check(stp_gl_renderer* r)
{
    GLenum reset = r->gl.GetGraphicsResetStatus();
    if (reset != GL_NO_ERROR) {
        return stp_fail(
            r->base.context, STP_ERROR_UNSUPPORTED,
            "gl: the graphics context was lost (%s); create the context and the renderer again",
            reset == GL_GUILTY_CONTEXT_RESET     ? "caused by this renderer"
            : reset == GL_INNOCENT_CONTEXT_RESET ? "caused by another program"
                                                 : "for an unknown reason");
    }
    if (r->debug != NULL && r->debug->errors > 0) {
        r->debug->errors = 0;
        return stp_fail(r->base.context, STP_ERROR_UNSUPPORTED, "gl: %s", r->debug->message);
    }
    return STP_OK;
}

static stp_result read_picture(stp_gl_renderer* r, stp_image* image)
{
    stp_gl_read_texture(&r->gl, r->target.picture, GL_RGBA, GL_UNSIGNED_BYTE, image->width,
                        image->height, band_bytes, image->pixels);
    return check(r);
}

static stp_result begin_picture(stp_gl_renderer* r, const stp_view* view, const stp_draw_list* list,
                                const stp_draw_style* style, const stp_image* image, uint32_t side)
{
    stp_result result = stp_renderer_check_view(&r->base, view, image);
    if (result != STP_OK) {
        return result;
    }
    stp_view one = stp_view_of_eye(view, 0);
    (void)stp_view_frame_make(&one, &r->placement.frame); // was checked
    if (side > SUPERSAMPLE_LIMIT) {
        return stp_fail(r->base.context, STP_ERROR_ARGUMENT,
                        "style: at most %d x %d samples per pixel", SUPERSAMPLE_LIMIT,
                        SUPERSAMPLE_LIMIT);
    }
    r->view = view;
    r->style = style;
    r->list = list;
    r->readback->has_depth = false;
    return stp_gl_target_make(r, view, side > 1);
}

/// Splats of a finished picture: those that reached the picture, in front or not. As many as listed
/// if the driver does not count them.
static uint64_t count_splats(stp_gl_renderer* r)
{
    uint64_t computed = stp_gl_shade_pass_read(r, GL_COUNTER_SPLATS);
    uint64_t drawn = r->target.eye_count * r->timer.drawn_splats +
                     computed / (r->counted_samples > 0 ? r->counted_samples : 1);
    return r->timer.counts && drawn < r->listed_splats ? drawn : r->listed_splats;
}

/// Times and pixels of a picture in progress (those of an earlier one), or finished.
static void read_times(stp_gl_renderer* r, bool done, stp_draw_stats* stats)
{
    stp_gl_timer_read(&r->gl, &r->timer, done);
    // estimate: each takes as long as the last
    double parts = (double)r->counted_samples * r->target.eye_count;
    stats->covered_pixels = done ? stp_gl_shade_pass_read(r, GL_COUNTER_COVERED) : 0;
    stats->fragments = r->target.eye_count * r->timer.fragments;
    stats->splats = done ? count_splats(r) : r->listed_splats;
    stats->draw_ms = r->timer.known ? parts * r->timer.draw_ms : stats->draw_ms;
    stats->shade_ms = parts * r->timer.shade_ms;
    stats->effect_ms = parts * r->timer.effect_ms;
    stats->layer_ms = parts * r->timer.layer_ms;
}

void stp_draw_gl_finish_stats(stp_renderer* renderer, stp_draw_stats* stats)
{
    read_times((stp_gl_renderer*)renderer, true, stats);
}

/// Statistics of a picture in progress, or finished if `image` was read.
static void count_picture(stp_gl_renderer* r, uint32_t samples, double cpu_ms, bool done,
                          stp_draw_stats* stats)
{
    uint32_t eyes = r->target.eye_count;
    r->counted_samples = samples;
    r->listed_splats = eyes * r->list->splat_count;
    stats->draw_ms = cpu_ms;
    read_times(r, done, stats);
    stats->triangles = r->frame.drawn_triangles;
    stats->listed_splats = r->listed_splats;
    stats->listed_triangles = eyes * (r->list->triangle_count + r->frame.large_count);
    stats->draw_calls = r->draw_calls;
    stats->layers = r->layer_pass.active ? r->layer_pass.count : 0;
    stats->samples = samples;
}

/// Whether the bytes of each sample are post-processed.
static bool works_on_bytes(const stp_gl_renderer* r, const stp_draw_style* style,
                           const stp_view* view)
{
    bool caps = style->caps && view->sections.count > 0;
    bool layers = r->layer_pass.possible && style->transparency != STP_TRANSPARENCY_PATTERN;
    return style->eye_dome > 0.0f || style->ambient_occlusion > 0.0f || caps || layers;
}

static stp_result draw_range(stp_gl_renderer* r, const stp_view* view, const stp_draw_list* list,
                             const stp_draw_style* style, const stp_gl_sample_range* range,
                             stp_image* image, stp_draw_stats* stats)
{
    assert(range->first <= range->end && (range->sums || range->end - range->first == 1));
    double start = stp_clock_ms();
    *stats = (stp_draw_stats){0};
    r->clock = (stp_gl_clock){0};
    stp_result result = begin_picture(r, view, list, style, image, range->side);
    for (uint32_t i = 0; i < stp_view_eye_count(view) && result == STP_OK; ++i) {
        result = stp_gl_draw_eye(r, i, range);
    }
    stp_gl_leave_state(r);
    double issued = stp_clock_ms();
    if (result == STP_OK) {
        result = image != NULL ? read_picture(r, image) : check(r);
    }
    r->clock.issue = issued - start - r->clock.prepare;
    r->clock.read = stp_clock_ms() - issued;
    if (result == STP_OK) {
        uint32_t samples = range->end - range->first;
        count_picture(r, samples, stp_clock_ms() - start, image != NULL, stats);
        stats->samples = range->end;
    }
    return result;
}

static stp_result draw(stp_renderer* renderer, const stp_view* view, const stp_draw_list* list,
                       const stp_draw_style* style, stp_image* image, stp_draw_stats* stats)
{
    stp_gl_renderer* r = (stp_gl_renderer*)renderer;
    uint32_t side = style->supersample > 1 ? style->supersample : 1;
    side = side <= SUPERSAMPLE_LIMIT ? side : SUPERSAMPLE_LIMIT + 1;
    bool bytes = side > 1 && works_on_bytes(r, style, view);
    stp_gl_sample_range range = {
        .side = side, .end = side * side, .sums = side > 1, .bytes = bytes, .scattered = bytes};
    r->accumulation.frames = 0; // its picture is overwritten, and its sums may be consumed or reset
    return draw_range(r, view, list, style, &range, image, stats);
}

static stp_result draw_selected(stp_renderer* renderer, const stp_view* view,
                                const stp_quality* quality, const stp_draw_style* style,
                                stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_gl_renderer* r = (stp_gl_renderer*)renderer;
    stp_quality whole = *quality;
    whole.occlusion = NULL;
    double start = stp_clock_ms();
    stp_result result = stp_select(renderer->context, r->store, view, &whole, list);
    double select_ms = stp_clock_ms() - start;
    r->visibility = quality->visibility;
    if (result == STP_OK) {
        result = draw(renderer, view, list, style, image, stats);
    }
    r->visibility = NULL;
    stats->select_ms = select_ms;
    return result;
}

static const float* get_depth(const stp_renderer* renderer)
{
    const stp_gl_renderer* r = (const stp_gl_renderer*)renderer;
    stp_gl_readback* back = r->readback;
    size_t count = (size_t)r->target.width * r->target.height * r->target.eye_count;
    if (count > back->capacity) {
        stp_free(renderer->context, back->depth);
        back->depth = STP_NEW_ARRAY(renderer->context, float, count);
        back->capacity = back->depth != NULL ? count : 0;
        back->has_depth = false;
    }
    if (back->depth != NULL && !back->has_depth && count > 0) {
        stp_gl_read_texture(&r->gl, r->target.depths, GL_RED, GL_FLOAT, r->target.width,
                            r->target.height * r->target.eye_count, band_bytes, back->depth);
        back->has_depth = true;
    }
    return back->depth;
}

static stp_result accumulate(stp_renderer* renderer, const stp_view* view,
                             const stp_quality* quality, const stp_draw_style* style,
                             stp_draw_list* list, stp_image* image, stp_draw_stats* stats)
{
    stp_gl_renderer* r = (stp_gl_renderer*)renderer;
    stp_draw_style finer = *style;
    finer.supersample = style->supersample > 2 ? style->supersample : 2;
    finer.supersample =
        finer.supersample <= SUPERSAMPLE_LIMIT ? finer.supersample : SUPERSAMPLE_LIMIT + 1;
    stp_quality whole = *quality;
    whole.occlusion = NULL;
    double start = stp_clock_ms();
    *stats = (stp_draw_stats){0};
    stp_result result = stp_select(renderer->context, r->store, view, &whole, list);
    double select_ms = stp_clock_ms() - start;
    if (result != STP_OK) {
        return result;
    }
    stp_gl_accumulation* a = &r->accumulation;
    bool same = stp_resting_continues(&a->resting, view, list, &finer) &&
                a->width == r->target.full_width && a->height == r->target.height &&
                r->frame.coming == 0;
    a->frames = same ? a->frames : 0;
    uint32_t all = finer.supersample * finer.supersample;
    stp_gl_sample_range range = {.side = finer.supersample,
                                 .first = a->frames,
                                 .end = a->frames < all ? a->frames + 1 : all,
                                 .sums = true,
                                 .bytes = true,
                                 .scattered = true};
    r->visibility = quality->visibility;
    result = draw_range(r, view, list, &finer, &range, image, stats);
    r->visibility = NULL;
    stats->select_ms = select_ms;
    a->frames = result == STP_OK ? range.end : 0;
    assert(a->frames <= all && "the mean of all samples is final");
    a->width = r->target.full_width;
    a->height = r->target.height;
    return result;
}

static void APIENTRY on_message(GLenum source, GLenum type, GLuint id, GLenum severity,
                                GLsizei length, const GLchar* message, const void* user)
{
    // user pointer to the renderer's memory, returned by OpenGL unchanged
    union {
        const void* given;
        stp_gl_debug* debug;
    } to = {.given = user};
    (void)source;
    (void)id;
    (void)severity;
    (void)length;
    if (type != GL_DEBUG_TYPE_ERROR) {
        return;
    }
    if (to.debug->errors++ == 0) {
        snprintf(to.debug->message, sizeof(to.debug->message), "%.*s", (int)strcspn(message, "\n"),
                 message);
    }
}

static stp_result listen(stp_gl_renderer* r)
{
    r->debug = STP_NEW_ZEROED(r->base.context, stp_gl_debug, 1);
    if (r->debug == NULL) {
        return stp_fail_memory(r->base.context);
    }
    r->gl.Enable(GL_DEBUG_OUTPUT);
    r->gl.Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    r->gl.DebugMessageCallback(on_message, r->debug);
    return STP_OK;
}

/// Queries the context, and checks the required features.
static stp_result check_context(stp_gl_renderer* r, const stp_draw_gl_desc* desc)
{
    stp_context* context = r->base.context;
    const char* lacking = stp_gl_load(&r->gl, desc);
    if (lacking != NULL) {
        return stp_fail(
            context, STP_ERROR_UNSUPPORTED,
            "gl: the context lacks %s: OpenGL 4.5 core with ARB_indirect_parameters is required",
            lacking);
    }
    const GLubyte* name = r->gl.GetString(GL_RENDERER);
    snprintf(r->device, sizeof(r->device), "%s", name != NULL ? (const char*)name : "unknown");
    r->is_software = strstr(r->device, "llvmpipe") != NULL ||
                     strstr(r->device, "softpipe") != NULL || strstr(r->device, "swrast") != NULL;
    GLint major = 0, minor = 0, blocks = 0;
    r->gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    r->gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    r->gl.GetIntegerv(GL_MAX_VERTEX_SHADER_STORAGE_BLOCKS, &blocks);
    if (10 * major + minor < 45 || blocks < 12 ||
        (10 * major + minor < 46 && !stp_gl_has(&r->gl, "GL_ARB_shader_draw_parameters"))) {
        return stp_fail(context, STP_ERROR_UNSUPPORTED,
                        "gl: %s has OpenGL %d.%d and %d storage blocks in vertex shaders; 4.5 with "
                        "ARB_shader_draw_parameters, and 12 blocks, are required",
                        r->device, major, minor, blocks);
    }
    GLfloat sizes[2] = {1.0f, 1.0f};
    r->gl.GetFloatv(GL_POINT_SIZE_RANGE, sizes);
    r->point_extent = stp_min((float)POINT_EXTENT, 0.5f * sizes[1] - 2.0f);
    return desc->debug ? listen(r) : STP_OK;
}

/// Bytes of the whole scene in the pool, at most about. Textures may be picture files; they become
/// texels with smaller levels, which take a third more.
static uint64_t estimate_bytes(const stp_store* store)
{
    uint64_t bytes = SCENE_TO_FILE * stp_store_file_bytes(store);
    uint32_t count = stp_store_get_directory(store)->texture_count;
    for (uint32_t i = 0; i < count; ++i) {
        const stp_store_texture* texture = stp_store_describe_texture(store, i);
        bytes += (uint64_t)texture->width * texture->height * TEXEL_SIZE * 4 / 3;
    }
    return bytes;
}

stp_result stp_draw_gl_create(stp_context* context, stp_store* store, const stp_draw_gl_desc* desc,
                              stp_renderer** renderer)
{
    stp_gl_renderer* r = STP_NEW_ZEROED(context, stp_gl_renderer, 1);
    *renderer = NULL;
    if (r == NULL) {
        return stp_fail_memory(context);
    }
    r->base = (stp_renderer){.context = context,
                             .destroy = destroy,
                             .draw = draw,
                             .draw_selected = draw_selected,
                             .accumulate = accumulate,
                             .depth = get_depth};
    r->store = store;
    r->directory = stp_store_get_directory(store);
    r->upload_bytes = desc->upload_bytes;
    r->readback = STP_NEW_ZEROED(context, stp_gl_readback, 1);
    stp_result result = r->readback != NULL ? check_context(r, desc) : stp_fail_memory(context);
    result = result == STP_OK ? stp_gl_entries_create(r) : result;
    if (result == STP_OK) {
        uint64_t memory = desc->memory_bytes > 0 ? desc->memory_bytes : default_memory;
        result = stp_gl_pool_create(context, &r->gl, r->entries.count, memory,
                                    estimate_bytes(store), &r->pool);
    }
    if (result == STP_OK) {
        stp_gl_timer_create(&r->gl, &r->timer);
        result = stp_gl_materials_create(r);
        r->front_only = stp_front_only_of_shadings(r->directory, r->front_only_shadings);
        result = result == STP_OK ? stp_gl_layer_pass_create(r) : result;
    }
    if (result == STP_OK) {
        result = check(r);
    }
    if (result != STP_OK) {
        destroy(&r->base);
        return result;
    }
    *renderer = &r->base;
    return STP_OK;
}

uint32_t stp_draw_gl_texture(const stp_renderer* renderer)
{
    return ((const stp_gl_renderer*)renderer)->target.picture;
}

stp_draw_gl_stats stp_draw_gl_get_stats(const stp_renderer* renderer)
{
    const stp_gl_renderer* r = (const stp_gl_renderer*)renderer;
    return (stp_draw_gl_stats){.memory_bytes = r->pool.limit_words * sizeof(uint32_t),
                               .resident_bytes = r->pool.spans.used * sizeof(uint32_t),
                               .uploaded_bytes = r->frame.uploaded_bytes,
                               .missing = r->frame.missing,
                               .coming = r->frame.coming,
                               .draw_calls = r->draw_calls,
                               .dispatches = r->dispatches,
                               .is_software = r->is_software,
                               .splats = r->splat_choice.used,
                               .prepare_ms = r->clock.prepare,
                               .issue_ms = r->clock.issue,
                               .read_ms = r->clock.read,
                               .device = r->device};
}
