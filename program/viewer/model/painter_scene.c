// SPDX-License-Identifier: MIT
#include "program/viewer/model/painter_scene.h"

#include "base/core/clock.h"
#include "draw/renderer.h"
#include "draw/transparency.h"
#include "program/viewer/model/splat_count.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/// Creates the CPU renderer and, with a memory limit, the loader.
static stp_result begin_drawing(paint_scene* s, bool loads)
{
    stp_result result = stp_draw_cpu_create(s->context, s->store, &s->renderers[0]);
    if (result == STP_OK && loads) {
        result = stp_residency_create(s->store, &(stp_residency_desc){0}, &s->residency);
        while (result == STP_OK && stp_residency_wait(s->residency)) { // loads the coarsest level
            stp_residency_update(s->residency, NULL, 0);
        }
    }
    return result;
}

static stp_result open_store(paint_scene* s, const paint_scene_desc* desc, const char* path)
{
    stp_result result = stp_store_open_partial(s->context, path, &s->store);
    s->loads = desc->memory_limit > 0;
    return result == STP_OK ? begin_drawing(s, s->loads) : result;
}

paint_scene* paint_scene_open(const paint_scene_desc* desc, const char* path, uint32_t serial)
{
    paint_scene* s = calloc(1, sizeof(*s));
    stp_context_desc context = {.log = desc->log,
                                .log_user = desc->log_user,
                                .thread_count = desc->thread_count,
                                .memory_limit_bytes = desc->memory_limit};
    if (s == NULL || stp_context_create(&s->context, &context) != STP_OK) {
        desc->log(STP_LOG_ERROR, "not enough memory to open the scene", desc->log_user);
        free(s);
        return NULL;
    }
    if (open_store(s, desc, path) != STP_OK) {
        paint_scene_close(s);
        return NULL;
    }
    const stp_store_directory* directory = stp_store_get_directory(s->store);
    s->shown = (painter_scene){.serial = serial, .store = s->store, .directory = directory};
    s->shown.bounds = directory->root != STP_STORE_NONE ? directory->nodes[directory->root].bounds
                                                        : stp_boxd_empty();
    for (uint32_t i = 0; i < SCENE_METHODS && i < stp_store_offered_methods(directory); ++i) {
        s->shown.splat_counts[i] = splat_count_of_scene(s->store, i);
    }
    s->transparent = stp_transparency_of_scene(directory);
    snprintf(s->shown.path, sizeof(s->shown.path), "%s", path);
    return s;
}

void paint_scene_close(paint_scene* s)
{
    if (s == NULL) {
        return;
    }
    for (int i = 0; i < 2; ++i) {
        if (s->renderers[i] != NULL) {
            stp_renderer_destroy(s->renderers[i]);
        }
    }
    if (s->visibility != NULL) {
        stp_visibility_destroy(s->visibility);
    }
    stp_residency_destroy(s->residency);
    stp_draw_list_destroy(s->context, &s->list);
    if (s->store != NULL) {
        stp_store_close(s->store);
    }
    stp_context_destroy(s->context);
    free(s);
}

bool paint_scene_use_gl(paint_scene* s, const stp_draw_gl_desc* gl, stp_gl_splats splats)
{
    if (s->renderers[1] == NULL && !s->gl_failed) {
        s->gl_failed = stp_draw_gl_create(s->context, s->store, gl, &s->renderers[1]) != STP_OK;
        if (!s->gl_failed) {
            stp_draw_gl_set_splats(s->renderers[1], splats);
        }
    }
    return !s->gl_failed;
}

static bool same_coloring(const stp_store_coloring* a, const stp_store_coloring* b)
{
    return a->by_attribute == b->by_attribute && a->attribute == b->attribute && a->low == b->low &&
           a->high == b->high && a->hides == b->hides &&
           memcmp(a->shown, b->shown, sizeof(a->shown)) == 0;
}

/// Whether points look the same: the range matters only for colours of attributes.
static bool is_same_point_style(const stp_store_coloring* a, const stp_store_coloring* b)
{
    bool plain = !a->by_attribute && !b->by_attribute && !a->hides && !b->hides;
    return plain || same_coloring(a, b);
}

bool paint_scene_color(paint_scene* s, const stp_store_coloring* points)
{
    if (s->renderers[0] != NULL && is_same_point_style(stp_store_get_coloring(s->store), points)) {
        return true;
    }
    for (int i = 0; i < 2; ++i) { // renderers cache scene data with the old colours
        if (s->renderers[i] != NULL) {
            stp_renderer_destroy(s->renderers[i]);
            s->renderers[i] = NULL;
        }
    }
    stp_residency_destroy(s->residency);
    s->residency = NULL;
    return stp_store_set_coloring(s->store, points) == STP_OK &&
           begin_drawing(s, s->loads) == STP_OK;
}

void paint_scene_set_stop(paint_scene* s, const atomic_bool* stop)
{
    for (int i = 0; i < 2; ++i) {
        if (s->renderers[i] != NULL) {
            stp_renderer_set_stop(s->renderers[i], stop);
        }
    }
}

stp_result paint_scene_show(paint_scene* s, const shown_list* list)
{
    stp_result result = STP_OK;
    if (s->visibility == NULL) {
        result = stp_visibility_create(s->context, s->store, &s->visibility);
    }
    return result == STP_OK ? shown_list_apply(list, s->visibility) : result;
}

static stp_result draw_once(paint_scene* s, const paint_request* request,
                            const stp_quality* quality, bool accumulates, bool gl, stp_image* image,
                            stp_draw_stats* stats)
{
    stp_draw_style style = request->style;
    stp_renderer* renderer = s->renderers[gl];
    if (accumulates) {
        style.supersample = request->samples;
        return stp_renderer_accumulate(renderer, &request->view, quality, &style, &s->list, image,
                                       stats);
    }
    return stp_renderer_draw_selected(renderer, &request->view, quality, &style, &s->list, image,
                                      stats);
}

stp_result paint_scene_draw(paint_scene* s, const paint_request* request, float splat_size,
                            bool accumulates, bool gl, stp_image* image, paint_figures* figures)
{
    assert(s->renderers[gl] != NULL && (image != NULL || gl));
    stp_draw_stats stats = {0};
    stp_quality quality = request->quality;
    quality.splat_size = splat_size;
    quality.visibility = s->visibility;
    double start = stp_clock_ms();
    stp_result result = draw_once(s, request, &quality, accumulates, gl, image, &stats);
    while (result == STP_ERROR_OUT_OF_MEMORY && s->residency != NULL &&
           stp_residency_yield(s->residency)) { // evicts loaded data to make room for pictures
        result = draw_once(s, request, &quality, accumulates, gl, image, &stats);
    }
    *figures = (paint_figures){.select_ms = stats.select_ms,
                               .draw_ms = stats.draw_ms,
                               .shade_ms = stats.shade_ms,
                               .splats = stats.splats,
                               .triangles = stats.triangles,
                               .nodes = s->list.node_count,
                               .layers = stats.layers,
                               .exceeds = stats.exceeds,
                               .samples = accumulates ? stats.samples : 1};
    if (s->residency != NULL && result == STP_OK) {
        stp_residency_stats before, loaded;
        stp_residency_get_stats(s->residency, &before);
        stp_residency_update(s->residency, s->list.requests, s->list.request_count);
        stp_residency_get_stats(s->residency, &loaded);
        figures->missing = loaded.missing > 0 && loaded.loading > 0 ? loaded.missing : 0;
        if (loaded.loaded != before.loaded) { // newly loaded data appears in the next frame
            figures->missing += 1;
        }
    }
    if (gl && result == STP_OK) {
        figures->missing += stp_draw_gl_get_stats(s->renderers[1]).coming;
    }
    figures->frame_ms = stp_clock_ms() - start;
    figures->cost =
        stp_draw_frame_cost(&request->style, &stats, s->list.splat_size, figures->frame_ms);
    figures->live_bytes = stp_context_live_bytes(s->context);
    return result;
}

double paint_near_distance(const stp_view* view)
{
    if (view->near_distance > 0.0) {
        return view->near_distance;
    }
    stp_vec3d gaze = stp_subd(view->target, view->eye);
    return 1e-4 * sqrt(stp_dotd(gaze, gaze)); // same as in stp_view_frame_make
}

bool paint_is_same_request(const paint_request* a, const paint_request* b)
{
    return a->scene == b->scene && a->budget_ms == b->budget_ms && a->samples == b->samples &&
           a->controller == b->controller && a->gl == b->gl &&
           stp_resting_is_same_view(&a->view, &b->view) &&
           stp_draw_style_is_same(&a->style, &b->style) &&
           is_same_point_style(&a->points, &b->points) &&
           stp_quality_is_same(&a->quality, &b->quality);
}
