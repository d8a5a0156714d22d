// SPDX-License-Identifier: MIT
//
// The window's loop: take what came (events, news of loading, pictures), move the camera, ask for a picture, show. Nothing
// here waits but for events.
#include "viewer.h"

#include "gui.h"
#include "state.h"

#include "base/clock.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    STEP_MS = 12,     ///< while the camera moves
    WORKING_MS = 100, ///< while something is loaded
    IDLE_MS = 1000,
    SETTLING_FRAMES = 3, ///< of the window, until all its parts know of an event
};

void viewer_redraw(viewer* v)
{
    v->dirty = SETTLING_FRAMES;
}

void viewer_say(viewer* v, bool is_error, const char* format, ...)
{
    va_list list;
    va_start(list, format);
    vsnprintf(v->message, sizeof(v->message), format, list);
    va_end(list);
    v->message_is_error = is_error;
    v->message_ms = stp_clock_ms();
    viewer_redraw(v);
}

// From any thread.
static void wake(void* user)
{
    viewer* v = user;
    SDL_Event event = {.type = v->wake_event};
    SDL_PushEvent(&event);
}

void viewer_open(viewer* v, const char* path)
{
    snprintf(v->file, sizeof(v->file), "%s", path);
    v->file_number += 1;
    v->message[0] = 0;
    loader_start(v->loader, v->file);
    const char* name = strrchr(path, '/') != NULL ? strrchr(path, '/') + 1 : path;
    char title[512];
    snprintf(title, sizeof(title), "%s - Stipple", name);
    SDL_SetWindowTitle(v->window.handle, title);
    viewer_redraw(v);
}

bool viewer_rests(const viewer* v)
{
    bool loads = v->news.state == LOADER_WORKING || v->news.state == LOADER_REFINING;
    bool shown = v->scene == NULL ||
                 (v->picture != NULL && v->picture->complete && v->picture->number == v->request &&
                  v->picture->scene == v->scene->serial);
    bool opens = v->news.store[0] != 0 && v->opening != v->news.serial;
    bool adopted = v->opening == 0 || v->news.state == LOADER_FAILED ||
                   (v->scene != NULL && v->scene->serial == v->opening) || v->message_is_error;
    return !loads && !opens && shown && adopted && v->glide_start < 0.0 && !v->input.flies;
}

static void take_news(viewer* v)
{
    loader_state before = v->news.state;
    double progress = v->news.fraction;
    loader_get_news(v->loader, &v->news);
    if (v->news.state != before || v->news.fraction != progress) {
        viewer_redraw(v);
    }
    if (v->news.store[0] != 0 && v->news.serial != v->opening) {
        v->opening = v->news.serial;
        painter_open(v->painter, v->news.store, v->news.serial);
    }
    if (v->news.state == LOADER_FAILED && before != LOADER_FAILED) {
        viewer_say(v, true, "%s", v->news.message);
    }
    const painter_scene* scene = painter_adopt(v->painter);
    if (scene != NULL) {
        v->scene = scene;
        if (v->shown_file_number != v->file_number || !v->has_camera) {
            v->shown_file_number = v->file_number;
            camera_begin(v);
        }
        viewer_redraw(v);
    }
    char message[512];
    bool is_error;
    if (painter_get_message(v->painter, message, sizeof(message), &is_error)) {
        viewer_say(v, is_error, "%s", message);
    }
}

static void take_picture(viewer* v)
{
    const painter_picture* picture = painter_take(v->painter);
    if (picture == NULL) {
        return;
    }
    v->picture = picture;
    if (!window_upload(&v->window, &picture->image)) {
        viewer_say(v, true, "the picture does not fit into the memory of the graphics device");
    }
    if (picture->figures.samples <= 1) {
        v->newest_time = (v->newest_time + 1) % FRAME_HISTORY;
        v->frame_times[v->newest_time] = (float)picture->figures.frame_ms;
    }
    v->dirty = v->dirty > 0 ? v->dirty : 1;
}

static void take_event(viewer* v, const SDL_Event* event)
{
    if (event->type == v->wake_event) {
        return;
    }
    gui_take_event(event);
    if (event->type == SDL_QUIT) {
        v->quits = true;
    } else if (event->type == SDL_DROPFILE) {
        viewer_open(v, event->drop.file);
        SDL_free(event->drop.file);
    }
    // a hand that turns the scene changes nothing of the panels
    if (event->type != SDL_MOUSEMOTION || v->input.drag == DRAG_NONE) {
        viewer_redraw(v);
    }
    input_take(v, event);
}

static void take_events(viewer* v)
{
    bool moves = v->input.flies || v->glide_start >= 0.0;
    bool works = v->news.state == LOADER_WORKING || v->news.state == LOADER_REFINING;
    int wait = v->dirty > 0 ? 0 : moves ? STEP_MS : works ? WORKING_MS : IDLE_MS;
    SDL_Event event;
    if (wait == 0 ? SDL_PollEvent(&event) : SDL_WaitEventTimeout(&event, wait)) {
        do {
            take_event(v, &event);
        } while (SDL_PollEvent(&event));
    }
}

static void show(viewer* v)
{
    window_clear(&v->window);
    gui_begin_frame();
    panels_show(v);
    gui_end_frame();
    window_show(&v->window);
    v->dirty -= 1;
    v->shows += 1;
}

static void step(viewer* v)
{
    take_events(v);
    double now = stp_clock_ms(), seconds = 1e-3 * (now - v->last_ms);
    v->last_ms = now;
    seconds = seconds < 0.1 ? seconds : 0.1; // after a pause nothing leaps
    if (window_measure(&v->window)) {
        viewer_redraw(v);
    }
    take_news(v);
    take_picture(v);
    v->picture_area = panels_layout(v);
    v->camera.width = (uint32_t)v->picture_area.width;
    v->camera.height = (uint32_t)v->picture_area.height;
    camera_step(v, seconds);
    input_step(v, seconds);
    if (v->scene != NULL) {
        paint_request request = request_make(v);
        v->request = painter_request(v->painter, &request);
    }
    if (v->dirty > 0) {
        show(v);
    }
    report_write(v, false);
}

static bool start(viewer* v)
{
    loader_desc loading = {.thread_count = v->options.thread_count,
                           .memory_limit = v->options.memory_limit,
                           .wake = wake,
                           .user = v};
    painter_desc painting = {.thread_count = v->options.thread_count,
                             .memory_limit = v->options.memory_limit,
                             .wake = wake,
                             .user = v};
    v->wake_event = SDL_RegisterEvents(1);
    v->loader = loader_create(&loading);
    v->painter = painter_create(&painting);
    return v->loader != NULL && v->painter != NULL;
}

static void set_options(viewer* v)
{
    const viewer_options* o = &v->options;
    v->settings = viewer_settings_default();
    viewer_settings_load(&v->settings);
    v->settings.gl = o->backend > 0 ? o->backend == 2 : v->settings.gl;
    v->settings.budget_ms = o->budget_ms > 0.0f ? o->budget_ms : v->settings.budget_ms;
    v->settings.adapts = o->budget_ms > 0.0f ? true : v->settings.adapts;
    v->shows_panels = true;
    v->glide_start = -1.0;
    v->last_ms = stp_clock_ms();
}

int viewer_run(const viewer_options* options)
{
    char reason[512];
    viewer* v = calloc(1, sizeof(*v));
    if (v == NULL) {
        return tool_error("out of memory");
    }
    v->options = *options;
    set_options(v);
    window_desc desc = {.title = "Stipple",
                        .width = (int)options->width,
                        .height = (int)options->height,
                        .software = options->software,
                        .scale = options->scale};
    if (!window_create(&v->window, &desc, reason, sizeof(reason))) {
        free(v);
        return tool_error("%s", reason);
    }
    int code = 0;
    if (!gui_create(v->window.handle, v->window.gl, v->window.renderer, v->window.scale) ||
        !start(v)) {
        code = tool_error("the window cannot be set up: out of memory");
        v->quits = true;
    } else if (options->file != NULL) {
        viewer_open(v, options->file);
    }
    viewer_redraw(v);
    while (!v->quits) {
        step(v);
    }
    if (code == 0) {
        report_write(v, true);
        viewer_settings_save(&v->settings);
    }
    painter_destroy(v->painter);
    loader_destroy(v->loader);
    input_destroy(v);
    gui_destroy();
    window_destroy(&v->window);
    SDL_Quit();
    free(v);
    return code;
}
