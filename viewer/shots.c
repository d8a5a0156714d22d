// SPDX-License-Identifier: MIT
// Saved pictures of any size, drawn aside: on a thread and with a renderer of their own, as fine as can be.
#include "parts.h"

#include "present/png.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct shot {
    pthread_t thread;
    atomic_bool done;
    bool failed;
    char store[PATH_ROOM], path[PATH_ROOM + 512], message[512];
    stp_view view;
    stp_draw_style style;
    stp_quality quality;
    shown_list shown;
    uint32_t thread_count;
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

static stp_result draw_shot(shot* s, stp_context* context, stp_store* store)
{
    stp_renderer* renderer = NULL;
    stp_visibility* visibility = NULL;
    stp_draw_list list = {0};
    stp_draw_stats stats;
    stp_image image = {.width = s->view.width, .height = s->view.height};
    image.pixels = stp_alloc_array(context, (size_t)image.width * image.height, 4);
    stp_result result = image.pixels == NULL ? stp_fail_memory(context)
                                             : stp_draw_cpu_create(context, store, &renderer);
    if (result == STP_OK && s->shown.count > 0) {
        result = stp_visibility_create(context, store, &visibility);
        result = result == STP_OK ? shown_list_apply(&s->shown, visibility) : result;
    }
    s->quality.visibility = visibility;
    if (result == STP_OK) {
        result = stp_renderer_draw_selected(renderer, &s->view, &s->quality, &s->style, &list,
                                            &image, &stats);
    }
    if (result == STP_OK) {
        result = stp_png_write(context, &image, s->path);
    }
    if (visibility != NULL) {
        stp_visibility_destroy(visibility);
    }
    stp_draw_list_destroy(context, &list);
    if (renderer != NULL) {
        stp_renderer_destroy(renderer);
    }
    stp_free(context, image.pixels);
    return result;
}

static void* run(void* user)
{
    shot* s = user;
    stp_context* context = NULL;
    stp_store* store = NULL;
    stp_context_desc desc = {.log = on_log, .log_user = s, .thread_count = s->thread_count};
    s->failed = stp_context_create(&context, &desc) != STP_OK ||
                stp_store_open(context, s->store, &store) != STP_OK ||
                draw_shot(s, context, store) != STP_OK;
    if (store != NULL) {
        stp_store_close(store);
    }
    if (context != NULL) {
        stp_context_destroy(context);
    }
    atomic_store(&s->done, true);
    s->wake(s->user);
    return NULL;
}

void shot_begin(viewer* v)
{
    if (v->scene == NULL || v->shot != NULL) {
        viewer_say(v, false, "%s",
                   v->shot != NULL ? "A picture is being saved already"
                                   : "Nothing to take a picture of yet");
        return;
    }
    shot* s = calloc(1, sizeof(*s));
    if (s == NULL) {
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
    s->thread_count = v->options.thread_count;
    s->wake = viewer_wake;
    s->user = v;
    if (v->explorer != NULL) {
        (void)explorer_list_shown(v->explorer, &s->shown);
    }
    snprintf(s->store, sizeof(s->store), "%s", v->scene->path);
    record_name_file(v, ".png", s->path, sizeof(s->path));
    if (pthread_create(&s->thread, NULL, run, s) != 0) {
        free(s->shown.things);
        free(s);
        viewer_say(v, true, "there is no thread to save the picture");
        return;
    }
    v->shot = s;
    viewer_say(v, false, "Saving %s", s->path);
}

void shot_end(viewer* v)
{
    if (v->shot != NULL) {
        pthread_join(v->shot->thread, NULL);
        free(v->shot->shown.things);
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
            viewer_say(v, true, "%s", s->message);
        } else {
            viewer_say(v, false, "Saved %s (%u x %u)", s->path, s->view.width, s->view.height);
        }
        shot_end(v);
    }
}
