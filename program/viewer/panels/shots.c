// SPDX-License-Identifier: MIT
// Saved pictures of any size, drawn at full quality on a separate thread with a separate renderer.
#include "base/core/context.h"
#include "program/present/picture_file.h"
#include "program/viewer/model/painter_scene.h"
#include "program/viewer/panels/panels.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FRAMES_MAX = 200 }; // maximum frames while data for a picture is loaded

struct shot {
    pthread_t thread;
    atomic_bool done;
    bool failed;
    char store[PATH_ROOM], path[PATH_ROOM + 512], message[512];
    stp_view view;
    stp_draw_style style;
    stp_quality quality;
    stp_store_coloring points;
    shown_list shown;
    uint32_t thread_count;
    uint64_t memory_limit;
    void (*wake)(void* user);
    void* user;
};

static void on_log(stp_log_level level, const char* message, void* user)
{
    shot* s = user;
    if (level == STP_LOG_ERROR) {
        snprintf(s->message, sizeof(s->message), "%s", message);
    }
}

/// Draws repeatedly until all wanted data is loaded, or memory is full.
static stp_result draw_loaded(shot* s, paint_scene* scene, stp_image* image)
{
    const paint_request request = {.view = s->view, .style = s->style, .quality = s->quality};
    stp_residency* loads = scene->residency;
    paint_figures figures;
    stp_result result = STP_OK;
    bool more = true;
    for (int i = 0; i < FRAMES_MAX && more && result == STP_OK; ++i) {
        result =
            paint_scene_draw(scene, &request, s->quality.splat_size, false, false, image, &figures);
        more = loads != NULL && stp_residency_wait(loads);
        for (int k = 0; k < FRAMES_MAX && loads != NULL && stp_residency_wait(loads); ++k) {
            stp_residency_update(loads, scene->list.requests, scene->list.request_count);
        }
    }
    return result;
}

static stp_result draw_shot(shot* s, paint_scene* scene)
{
    stp_image image = {.width = s->view.width, .height = s->view.height};
    image.pixels = stp_alloc_array(scene->context, (size_t)image.width * image.height, 4);
    stp_result result = image.pixels == NULL ? stp_fail_memory(scene->context) : STP_OK;
    if (result == STP_OK && !paint_scene_color(scene, &s->points)) {
        result = STP_ERROR_OUT_OF_MEMORY; // already logged
    }
    if (result == STP_OK && s->shown.count > 0) {
        result = paint_scene_show(scene, &s->shown);
    }
    if (result == STP_OK) {
        result = draw_loaded(s, scene, &image);
    }
    if (result == STP_OK) {
        result = stp_png_write(scene->context, &image, s->path);
    }
    stp_free(scene->context, image.pixels);
    return result;
}

static void* run(void* user)
{
    shot* s = user;
    paint_scene_desc desc = {.thread_count = s->thread_count,
                             .memory_limit = s->memory_limit,
                             .log = on_log,
                             .log_user = s};
    paint_scene* scene = paint_scene_open(&desc, s->store, 1);
    s->failed = scene == NULL || draw_shot(s, scene) != STP_OK;
    paint_scene_close(scene);
    atomic_store(&s->done, true);
    s->wake(s->user);
    return NULL;
}

void shot_begin(viewer* v)
{
    if (v->scene == NULL || v->shot != NULL) {
        viewer_show_message(v, false, "%s",
                            v->shot != NULL ? "A picture is already being saved"
                                            : "Open a model first");
        return;
    }
    shot* s = calloc(1, sizeof(*s));
    bool memory = s != NULL;
    if (memory && v->explorer != NULL) { // without the list, hidden parts would be drawn
        memory = explorer_list_shown(v->explorer, &s->shown);
    }
    if (!memory) {
        free(s);
        viewer_show_message(v, true, "not enough memory to save the picture");
        return;
    }
    paint_request request = request_make(v);
    s->view = request.view;
    s->view.width = (uint32_t)v->settings.shot_width;
    s->view.height = (uint32_t)v->settings.shot_height;
    s->style = request.style;
    s->style.background = !v->shot_clear;
    s->style.supersample = (uint32_t)v->settings.shot_samples;
    s->quality = request.quality;
    s->points = request.points;
    s->thread_count = v->options.thread_count;
    s->memory_limit = v->options.memory_limit;
    s->wake = viewer_wake;
    s->user = v;
    snprintf(s->store, sizeof(s->store), "%s", v->scene->path);
    record_name_file(v, ".png", s->path, sizeof(s->path));
    if (pthread_create(&s->thread, NULL, run, s) != 0) {
        free(s->shown.objects);
        free(s);
        viewer_show_message(v, true, "cannot start a thread to save the picture");
        return;
    }
    v->shot = s;
    viewer_show_message(v, false, "Saving %s", s->path);
}

void shot_end(viewer* v)
{
    if (v->shot != NULL) {
        pthread_join(v->shot->thread, NULL);
        free(v->shot->shown.objects);
        free(v->shot);
        v->shot = NULL;
    }
}

void shot_step(viewer* v)
{
    shot* s = v->shot;
    if (s != NULL && atomic_load(&s->done)) {
        snprintf(v->last_shot, sizeof(v->last_shot), "%s", s->failed ? "" : s->path);
        if (s->failed) {
            viewer_show_message(v, true, "%s", s->message);
        } else {
            viewer_show_message(v, false, "Saved %s (%u x %u)", s->path, s->view.width,
                                s->view.height);
        }
        shot_end(v);
    }
}
