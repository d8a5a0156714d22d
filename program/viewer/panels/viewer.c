// SPDX-License-Identifier: MIT
//
// The window's loop: handle events, loading news and pictures, move the camera, request a picture,
// show it. It waits only for events.
#include "program/viewer/panels/viewer.h"

#include "base/core/clock.h"
#include "lod/method.h"
#include "program/options/program.h"
#include "program/viewer/panels/panels.h"
#include "program/viewer/window/gui.h"

#include <assert.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    STEP_MS = 12,     ///< while the camera moves
    WORKING_MS = 100, ///< while something is loaded
    IDLE_MS = 1000,
    SETTLING_FRAMES = 3, ///< window frames until all parts have reacted to an event
};

void viewer_redraw(viewer* v)
{
    v->dirty = SETTLING_FRAMES;
}

void viewer_wake(void* user)
{
    viewer* v = user;
    SDL_Event event = {.type = v->wake_event};
    SDL_PushEvent(&event);
}

/// Starts loading the current inputs.
static void load(viewer* v)
{
    const scene_input input = {(const char* const*)v->inputs.paths, v->inputs.count, v->up,
                               v->unit_metres};
    v->file_number += 1;
    v->former = v->opening;
    messages_clear(v);
    v->record.plays = false;
    views_begin(v);
    if (!loader_start(v->loader, &input)) {
        viewer_show_message(v, true, "not enough memory to load the file");
    }
    const char* slash = strrchr(v->file, '/');
    char title[512], more[32] = "";
    if (v->more > 0) {
        snprintf(more, sizeof(more), " and %zu more", v->more);
    }
    snprintf(title, sizeof(title), "%.400s%s - Stipple", slash != NULL ? slash + 1 : v->file, more);
    SDL_SetWindowTitle(v->window.handle, title);
    viewer_redraw(v);
}

/// Whether up axis and unit of all inputs can be corrected: none of them is built yet.
static bool can_correct(const path_list* inputs)
{
    for (size_t i = 0; i < inputs->count; ++i) {
        if (program_is_scene(inputs->paths[i]) || tool_is_store_file(inputs->paths[i])) {
            return false;
        }
    }
    return inputs->count > 0;
}

void viewer_open_all(viewer* v, const char* const* paths, size_t count)
{
    path_list inputs = {0};
    bool good = count > 0;
    for (size_t i = 0; i < count && good; ++i) {
        good = path_list_expand(&inputs, paths[i]);
    }
    if (!good || inputs.count == 0) {
        path_list_destroy(&inputs);
        viewer_show_message(v, true,
                            good ? "%s: the folder holds no models" : "%s: too many files to open",
                            paths[0]);
        return;
    }
    path_list_destroy(&v->inputs);
    v->inputs = inputs;
    v->can_correct = can_correct(&inputs);
    v->more = count - 1;
    snprintf(v->file, sizeof(v->file), "%s", paths[0]);
    for (size_t end = strlen(v->file); end > 1 && v->file[end - 1] == '/'; --end) {
        v->file[end - 1] = 0;
    }
    v->up = v->options.up;
    v->unit_metres = v->options.unit_metres;
    v->options.up = 0; // only for the first file
    v->options.unit_metres = 0.0;
    load(v);
}

void viewer_open(viewer* v, const char* path)
{
    viewer_open_all(v, &path, 1);
}

void viewer_correct(viewer* v, char up, double unit_metres)
{
    v->up = up;
    v->unit_metres = unit_metres;
    load(v);
}

bool viewer_is_idle(const viewer* v)
{
    bool loads = v->news.state == LOADER_WORKING || v->news.state == LOADER_REFINING;
    bool shown = v->scene == NULL ||
                 (v->picture != NULL && v->picture->complete && v->picture->number == v->request &&
                  v->picture->scene == v->scene->serial);
    bool opens = v->news.store[0] != 0 && v->opening != v->news.serial;
    bool adopted = v->opening == 0 || v->news.state == LOADER_FAILED ||
                   (v->scene != NULL && v->scene->serial == v->opening) ||
                   messages_error(v) != NULL;
    bool reads = v->explorer != NULL && explorer_works(v->explorer);
    bool moves = v->glide_start >= 0.0 || input_moves(v) || v->record.plays;
    return !loads && !opens && shown && adopted && !moves && !reads && v->shot == NULL;
}

/// Creates the window's own data of a new scene.
static void explore(viewer* v, bool same_file)
{
    explorer* before = v->explorer;
    if (same_file && before != NULL && before->mark_count > 0) {
        views_keep_hidden(v);
    }
    v->explorer = explorer_create(v->scene->path);
    v->marks_version = 0;
    if (v->explorer == NULL && v->scene->serial > v->former) {
        viewer_show_message(v, true, "%s: cannot read the parts", v->file);
    } else if (v->explorer != NULL && same_file && before != NULL) {
        explorer_follow(v->explorer, before);
    }
    if (!same_file) {
        v->has_picked = false;
        v->measure = (measure_state){.snaps = true};
        v->search[0] = 0;
        section_begin(v);
    }
    explorer_destroy(before);
}

static void step_explorer(viewer* v)
{
    explorer* e = v->explorer;
    if (e == NULL) {
        return;
    }
    if (explorer_step(e)) {
        viewer_redraw(v);
    }
    views_restore_hidden(v);
    if (e->marks_version != v->marks_version) {
        shown_list list; // tried again in the next step if memory runs out
        if (explorer_list_shown(e, &list)) {
            v->marks_version = e->marks_version;
            painter_show(v->painter, v->scene->serial, &list);
            viewer_redraw(v);
        }
    }
    if (e->message[0] != 0) { // shown once
        viewer_show_message(v, true, "%s", e->message);
        e->message[0] = 0;
    }
}

/// Whether the scene lacks splats of the requested method.
static bool lacks_method(const viewer* v)
{
    const stp_store_directory* d = v->scene->directory;
    uint32_t id = v->options.method;
    return id != 0 && d->set_count != 0 && d->methods[stp_store_find_method(d, id)].id != id;
}

static void take_scene(viewer* v)
{
    // the first camera fits beside the panels, whose heights are known after they have been shown
    const painter_scene* scene = v->shows > 0 ? painter_adopt(v->painter) : NULL;
    if (scene == NULL) {
        return;
    }
    // a scene that was still opening when another file was chosen is not a draft of that file
    uint32_t number = scene->serial <= v->former ? v->file_number - 1 : v->file_number;
    bool same_file = v->shown_file_number == number && v->has_camera;
    v->scene = scene;
    explore(v, same_file);
    if (same_file) {
        point_style_follow(v); // a draft may lack the splats that tell
    } else {
        v->shown_file_number = number;
        if (v->more == 0) {
            start_opened(v->start, v->file);
        }
        camera_begin(v);
        point_style_begin(v);
        if (stp_boxd_is_empty(v->scene->bounds)) {
            viewer_show_message(v, false, "%s: no visible content", v->file);
        } else if (lacks_method(v)) {
            viewer_show_message(v, false, "%s has splats by %s, not by %s", v->file,
                                v->scene->directory->methods[0].name,
                                stp_method_by_id(v->options.method)->name);
        }
    }
    if (v->news.complete && scene->serial == v->news.serial) {
        loader_drop_drafts(v->loader);
    }
    viewer_redraw(v);
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
        viewer_show_message(v, true, "%s", v->news.message);
    }
    take_scene(v);
    char message[512];
    bool is_error;
    if (painter_get_message(v->painter, message, sizeof(message), &is_error)) {
        viewer_show_message(v, is_error, "%s", message);
    }
}

static void take_picture(viewer* v)
{
    const painter_picture* picture = painter_take(v->painter);
    if (picture == NULL) {
        return;
    }
    v->picture = picture;
    if (picture->texture != 0) {
        window_borrow(&v->window, picture->texture);
    } else if (!window_upload(&v->window, &picture->image)) {
        viewer_show_message(v, true, "not enough graphics memory for the picture");
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
        (void)path_list_add(&v->dropped, event->drop.file);
        SDL_free(event->drop.file);
    } else if (event->type == SDL_DROPCOMPLETE && v->dropped.count > 0) {
        viewer_open_all(v, (const char* const*)v->dropped.paths, v->dropped.count);
        path_list_destroy(&v->dropped);
    }
    // dragging the scene does not change the panels
    if (event->type != SDL_MOUSEMOTION || v->input.drag == DRAG_NONE) {
        viewer_redraw(v);
    }
    input_take(v, event);
}

/// Maximum time to wait for events.
static int choose_wait(viewer* v)
{
    bool works = v->news.state == LOADER_WORKING || v->news.state == LOADER_REFINING;
    bool moves = input_moves(v) || v->glide_start >= 0.0 || v->record.plays || v->record.on ||
                 (v->explorer != NULL && explorer_works(v->explorer));
    if (v->dirty == 0 && gui_awaits_tooltip()) {
        v->dirty = 1; // a tooltip is about to appear
        return WORKING_MS;
    }
    return v->dirty > 0 ? 0 : moves ? STEP_MS : works ? WORKING_MS : IDLE_MS;
}

static void take_events(viewer* v)
{
    int wait = choose_wait(v);
    SDL_Event event;
    if (wait == 0 ? SDL_PollEvent(&event) : SDL_WaitEventTimeout(&event, wait)) {
        // ImGui reads the key states when a frame begins; a key pressed and released between two
        // frames would be missed
        bool for_text;
        do {
            take_event(v, &event);
            for_text = (event.type == SDL_KEYDOWN || event.type == SDL_KEYUP) && gui_wants_keys();
        } while (!for_text && SDL_PollEvent(&event));
    }
}

static void show(viewer* v)
{
    assert(v->dirty > 0 && "shown only if something changed");
    window_clear(&v->window);
    gui_begin_frame(v->window.width, v->window.height, v->window.density);
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
    seconds = seconds < 0.1 ? seconds : 0.1; // avoids a jump after a pause
    if (window_measure(&v->window)) {
        viewer_redraw(v);
    }
    take_news(v);
    take_picture(v);
    v->picture_area = panels_layout(v);
    v->camera.width = (uint32_t)v->picture_area.width;
    v->camera.height = (uint32_t)v->picture_area.height;
    assert(v->camera.width > 0 && v->camera.height > 0 && "panels leave room for a picture");
    framing_step(v);
    camera_step(v, seconds);
    input_step(v, seconds);
    step_explorer(v);
    record_step(v);
    shot_step(v);
    // hidden parts of a growing scene must not flash up
    bool waits = v->carried.count > 0 && v->explorer != NULL && explorer_works(v->explorer);
    if (v->scene != NULL && !waits) {
        paint_request request = request_make(v);
        v->request = painter_request(v->painter, &request);
    }
    if (v->dirty > 0) {
        show(v);
    }
    report_write(v, false);
}

// Shows messages of the window's own context, which reads and writes viewpoints and flights.
static void on_log(stp_log_level level, const char* message, void* user)
{
    if (level != STP_LOG_NOTICE) {
        viewer_show_message(user, level == STP_LOG_ERROR, "%s", message);
    }
}

static bool start(viewer* v)
{
    loader_desc loading = {.thread_count = v->options.thread_count,
                           .memory_limit = v->options.memory_limit,
                           .use = scene_use_of_method(v->options.method),
                           .wake = viewer_wake,
                           .user = v};
    painter_desc painting = {.begin_gl = window_begin_worker,
                             .end_gl = window_end_worker,
                             .get_proc_address = window_get_proc_address,
                             .gl_user = &v->window,
                             .gl_splats = (stp_gl_splats)v->options.gl_splats,
                             .thread_count = v->options.thread_count,
                             .memory_limit = v->options.memory_limit,
                             .wake = viewer_wake,
                             .user = v};
    stp_context_desc context = {.log = on_log, .log_user = v, .thread_count = 1};
    v->wake_event = SDL_RegisterEvents(1);
    if (stp_context_create(&v->context, &context) != STP_OK) {
        return false;
    }
    v->start = start_create();
    if (v->start == NULL) {
        return false;
    }
    v->loader = loader_create(&loading);
    v->painter = painter_create(&painting);
    return v->loader != NULL && v->painter != NULL;
}

static void set_options(viewer* v)
{
    const viewer_options* o = &v->options;
    stp_quality* quality = &v->settings.drawing.quality;
    v->settings = viewer_settings_default();
    viewer_settings_load(&v->settings);
    v->settings.backend = o->backend > 0 ? o->backend : v->settings.backend;
    v->settings.budget_ms = o->budget_ms > 0.0f ? o->budget_ms : v->settings.budget_ms;
    v->settings.adapts = o->budget_ms > 0.0f ? true : v->settings.adapts;
    if (o->splat_count > 0) {
        quality->reference = false;
        quality->splat_count = o->splat_count;
    } else if (o->budget_ms > 0.0f) {
        quality->splat_count = 0;
    }
    if (o->has_point_size) {
        bool fixed = o->point_size.width > 0.0, metres = o->point_size.in_metres;
        float width = (float)o->point_size.width;
        v->settings.drawing.style.point_sizing = !fixed   ? STP_POINTS_ADAPTIVE
                                                 : metres ? STP_POINTS_UNITS
                                                          : STP_POINTS_PIXELS;
        v->settings.point_metres = fixed && metres ? width : v->settings.point_metres;
        v->settings.point_pixels = fixed && !metres ? width : v->settings.point_pixels;
    }
    if (o->has_back_faces) {
        v->settings.drawing.style.back_faces = o->back_faces;
    }
    quality->method = o->method != 0 ? o->method : quality->method;
    v->shows_panels = true;
    v->measure.snaps = true;
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
        code = tool_error("cannot set up the window: out of memory");
        v->quits = true;
    } else if (options->file_count > 0) {
        viewer_open_all(v, options->files, options->file_count);
    }
    input_begin(v);
    if (options->backend == BACKEND_OPENGL && !v->window.has_worker) {
        viewer_show_message(v, false, "OpenGL 4.5 is not available; using the CPU renderer");
    }
    viewer_redraw(v);
    while (!v->quits) {
        step(v);
    }
    if (code == 0) {
        report_write(v, true);
        viewer_settings_save(&v->settings);
    }
    shot_end(v);
    record_end(v);
    painter_destroy(v->painter);
    loader_destroy(v->loader);
    explorer_destroy(v->explorer);
    start_destroy(v->start);
    if (v->context != NULL) {
        views_end(v);
        stp_context_destroy(v->context);
    }
    selection_end(v);
    path_list_destroy(&v->inputs);
    path_list_destroy(&v->dropped);
    input_destroy(v);
    gui_destroy();
    window_destroy(&v->window);
#ifndef STP_SANITIZED // drivers stay loaded, so that leak reports can attribute their leaks to them
    SDL_Quit();
#endif
    free(v);
    return code;
}
