// SPDX-License-Identifier: MIT
#include "program/viewer/model/paint_thread.h"

#include "base/core/clock.h"
#include "program/viewer/model/painter_scene.h"

#include <assert.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { BUFFERS = 3 };                // one is drawn, one is ready, one is shown
static const double rest_ms = 120.0; // the camera is at rest after this time without a request
static const double loading_ms = 30.0;
static const double finest_ms = 6000.0; // no finer picture is started if it would take longer
static const double whole_ms = 250.0;   // splats shrink in one step at rest if that takes no longer

/// Progress of a request's picture.
typedef enum paint_stage { STAGE_MOVES, STAGE_RESTS, STAGE_ACCUMULATES, STAGE_DONE } paint_stage;

struct painter {
    painter_desc desc;
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool quits;
    bool refines;     ///< the current frame refines a picture at rest
    atomic_bool stop; ///< abort it: another picture is wanted
    // the request
    paint_request request;
    uint64_t number;   ///< number of the request
    double request_ms; ///< time of the request
    char open_path[PATH_MAX];
    uint32_t open_serial, opened_serial;
    // the results
    paint_scene* opened; ///< not adopted yet
    paint_scene* current;
    painter_picture pictures[BUFFERS];
    int painting, ready, shown;
    shown_list wanted_list; ///< for scene list_scene; owns its objects
    uint32_t list_scene;
    bool has_list; ///< it has not been applied yet
    bool fresh;    ///< `ready` has not been taken
    uint64_t frame;
    char message[512];
    bool message_is_error;
    // used by the painter thread only
    painter_gl gl;
    stp_draw_gl_desc gl_desc;
    bool uses_gl;       ///< for the frame being drawn
    bool gl_lost;       ///< the OpenGL context was lost
    paint_scene* scene; ///< adopted and requested
    uint64_t begun;     ///< number of the request being drawn
    double begun_ms;    ///< time of the request
    uint64_t answered;  ///< number of the last request with a picture
    double latency_ms;  ///< from the request to its first picture
    paint_stage stage;
    float size;         ///< splat size of the last frame
    bool left_out;      ///< the last frame had fewer effects than the request, for lack of time
    double expected_ms; ///< forecast for the next frame of the same request
    bool loads;         ///< data missing in the last frame is being loaded
    double budget_ms;
    stp_controller controller;
};

static void on_log(stp_log_level level, const char* message, void* user)
{
    painter* p = user;
    if (level == STP_LOG_NOTICE) {
        return;
    }
    // the mutex is not held while the thread opens or draws, so it can be locked here
    pthread_mutex_lock(&p->mutex);
    snprintf(p->message, sizeof(p->message), "%s", message);
    p->message_is_error = level == STP_LOG_ERROR;
    pthread_mutex_unlock(&p->mutex);
    p->desc.wake(p->desc.user);
}

/// Allocates a picture. @return false if memory runs out
static bool fit_picture(painter_picture* picture, uint32_t width, uint32_t height)
{
    size_t needed = (size_t)width * height;
    if (needed > picture->capacity) {
        free(picture->image.pixels);
        free(picture->nearness);
        picture->capacity = 0;
        picture->image.pixels = malloc(needed * 4);
        picture->nearness = malloc(needed * sizeof(float));
        if (picture->image.pixels == NULL || picture->nearness == NULL) {
            return false;
        }
        picture->capacity = needed;
    }
    picture->image.width = width;
    picture->image.height = height;
    return true;
}

/// Splat size of the next frame at rest: the finest, or in steps while that would take long.
static float choose_rest_size(const painter* p, float finest)
{
    float half = 0.5f * p->size;
    double whole = stp_budget_predict(&p->scene->budgets[p->uses_gl], (double)finest);
    return half > finest && whole > whole_ms ? half : finest;
}

/// Splat size of the next frame, by stage.
static float choose_size(painter* p, const paint_request* request)
{
    float finest = request->quality.splat_size > 0.0f ? request->quality.splat_size : 1.0f;
    if (!(request->budget_ms > 0.0) || p->stage == STAGE_ACCUMULATES) {
        return p->stage == STAGE_ACCUMULATES && request->budget_ms > 0.0 ? p->size : finest;
    }
    float moving = stp_budget_splat_size(&p->scene->budgets[p->uses_gl]);
    moving = moving > finest ? moving : finest;
    if (p->stage == STAGE_MOVES) {
        return moving;
    }
    return choose_rest_size(p, finest);
}

/// Style of the next frame, by stage. Without a limit of its time, a moving picture has no layers.
static stp_draw_style choose_style(const painter* p, const paint_request* request)
{
    const uint32_t layers = 1u << STP_EFFECT_LAYERS;
    if (p->stage != STAGE_MOVES) {
        return request->style;
    }
    uint32_t left_out =
        request->budget_ms > 0.0 ? stp_budget_left_out(&p->scene->budgets[p->uses_gl]) : layers;
    left_out &= p->scene->transparent ? ~0u : ~layers;
    return stp_draw_style_without(&request->style, left_out);
}

/// The stage after a frame, and the forecast of its time. Samples are accumulated however long a
/// frame takes: a machine that is busy for a moment, or a driver that compiles, must not decide
/// what is seen at rest, and the next request stops it.
static paint_stage next_stage(painter* p, const paint_request* request,
                              const paint_figures* figures)
{
    p->expected_ms = figures->frame_ms;
    float finest = request->quality.splat_size > 0.0f ? request->quality.splat_size : 1.0f;
    if (p->stage == STAGE_ACCUMULATES) {
        return figures->samples >= request->samples * request->samples ? STAGE_DONE
                                                                       : STAGE_ACCUMULATES;
    }
    if (request->budget_ms > 0.0 && p->size > finest) {
        p->expected_ms =
            stp_budget_predict(&p->scene->budgets[p->uses_gl], (double)choose_rest_size(p, finest));
        return p->expected_ms < finest_ms ? STAGE_RESTS : STAGE_DONE;
    }
    bool accumulates = request->samples > 1;
    if (!accumulates && p->stage == STAGE_MOVES && p->left_out) {
        return STAGE_RESTS; // draw once more, with all effects
    }
    return accumulates ? STAGE_ACCUMULATES : STAGE_DONE;
}

static void update_budget(painter* p, const paint_request* request, const paint_figures* f)
{
    if (request->budget_ms != p->budget_ms || request->controller != p->controller) {
        p->budget_ms = request->budget_ms;
        p->controller = request->controller;
        if (request->budget_ms > 0.0) {
            stp_budget_init(&p->scene->budgets[0], request->controller, request->budget_ms);
            stp_budget_init(&p->scene->budgets[1], request->controller, request->budget_ms);
        }
    }
    if (request->budget_ms > 0.0 && f != NULL) {
        stp_frame_cost cost = {.milliseconds = f->work_ms,
                               .splats = f->listed_splats,
                               .fragments = f->fragments,
                               .triangles = f->listed_triangles,
                               .covered_pixels = f->covered_pixels,
                               .draw_calls = (uint32_t)f->draw_calls,
                               .splat_size = f->splat_size};
        memcpy(cost.effect_ms, f->effect_ms, sizeof(cost.effect_ms));
        stp_budget_update(&p->scene->budgets[p->uses_gl], &cost);
    }
}

static void copy_depth(painter* p, painter_picture* picture)
{
    const float* nearness = stp_renderer_depth(p->scene->renderers[p->uses_gl]);
    size_t count = (size_t)picture->image.width * picture->image.height;
    assert(count <= picture->capacity);
    if (nearness != NULL) {
        memcpy(picture->nearness, nearness, count * sizeof(float));
    } else {
        memset(picture->nearness, 0, count * sizeof(float));
    }
    size_t pixel = 0;
    while (pixel < count && !(picture->nearness[pixel] > 0.0f)) {
        pixel += 1;
    }
    picture->is_empty = nearness != NULL && pixel == count;
}

/// Adds OpenGL's timings of a finished frame to its figures. The budget learns from work_ms: CPU
/// and GPU time.
static void measure_gl(painter* p, const paint_request* request, paint_figures* figures)
{
    stp_draw_stats stats = {.layers = figures->layers};
    stp_draw_gl_finish_stats(p->scene->renderers[1], &stats);
    figures->draw_ms = stats.draw_ms;
    figures->shade_ms = stats.shade_ms;
    figures->splats = stats.splats;
    figures->fragments = stats.fragments;
    figures->covered_pixels = stats.covered_pixels;
    figures->work_ms = fmin(figures->frame_ms, figures->work_ms + stats.draw_ms + stats.shade_ms);
    stp_draw_split_effects(&request->style, &stats, figures->work_ms, figures->effect_ms);
}

/// Draws one frame; *texture receives its texture if OpenGL draws. The context may be lost in the
/// process. @return false if there is no picture: drawing failed or was aborted
static bool draw(painter* p, const paint_request* request, float size, bool accumulates,
                 uint32_t* texture, paint_figures* figures)
{
    painter_picture* picture = &p->pictures[p->painting];
    const stp_view* view = &request->view;
    double start = stp_clock_ms();
    *texture = 0;
    if (!fit_picture(picture, view->width, view->height)) {
        on_log(STP_LOG_ERROR, "not enough memory for the picture", p);
        return false;
    }
    stp_result result = paint_scene_draw(p->scene, request, size, accumulates, p->uses_gl,
                                         p->uses_gl ? NULL : &picture->image, figures);
    if (result == STP_OK && p->uses_gl) {
        *texture = painter_gl_keep(&p->gl, p->painting, stp_draw_gl_texture(p->scene->renderers[1]),
                                   view->width, view->height);
        figures->frame_ms = stp_clock_ms() - start; // until the picture is complete
        measure_gl(p, request, figures);
    }
    p->gl_lost =
        p->gl_lost ||
        (p->uses_gl && (result == STP_ERROR_UNSUPPORTED || (result == STP_OK && *texture == 0)));
    return result == STP_OK && !(p->uses_gl && *texture == 0);
}

/// Aborts a running refinement. The mutex is held. Frames of a moving camera are finished:
/// otherwise none would appear while requests arrive faster than frames.
static void abandon_refinement(painter* p)
{
    if (p->refines) {
        atomic_store(&p->stop, true);
    }
}

/// Draws one frame without the mutex and makes it the ready picture. The mutex is held on entry and
/// exit.
static void paint(painter* p)
{
    paint_request request = p->request;
    painter_picture* picture = &p->pictures[p->painting];
    atomic_store(&p->stop, false);
    p->refines = p->stage != STAGE_MOVES;
    pthread_mutex_unlock(&p->mutex);
    bool ready = paint_scene_color(p->scene, &request.points);
    paint_figures figures = {0};
    p->uses_gl = request.gl && !p->gl_lost && p->gl.functions != NULL && ready &&
                 paint_scene_use_gl(p->scene, &p->gl_desc, p->desc.gl_splats);
    paint_scene_set_stop(p->scene, p->refines ? &p->stop : NULL);
    update_budget(p, &request, NULL);
    bool accumulates = p->stage == STAGE_ACCUMULATES;
    float size = choose_size(p, &request);
    uint32_t texture = 0;
    const stp_draw_style whole = request.style;
    request.style = choose_style(p, &request);
    p->left_out = !stp_draw_style_is_same(&whole, &request.style);
    bool drawn = ready && draw(p, &request, size, accumulates, &texture, &figures);
    if (ready && p->gl_lost && p->uses_gl) {
        on_log(STP_LOG_WARNING, "The OpenGL context was lost; using the CPU renderer from now on",
               p);
        p->uses_gl = false;
        drawn = draw(p, &request, size, accumulates, &texture, &figures);
    }
    if (drawn) {
        p->size = size;
        if (!p->refines) { // the budget does not learn from refinement, which uses another splat
                           // size and which nobody waits for
            update_budget(p, &request, &figures);
        }
        copy_depth(p, picture);
    }
    pthread_mutex_lock(&p->mutex);
    p->refines = false;
    if (!drawn) {
        // until the next request; an aborted refinement resumes with it
        p->stage = atomic_load(&p->stop) ? STAGE_RESTS : STAGE_DONE;
        return;
    }
    p->stage = next_stage(p, &request, &figures);
    p->loads = figures.missing > 0;
    picture->view = request.view;
    picture->gl = p->uses_gl;
    picture->texture = texture;
    picture->scene = request.scene;
    picture->number = p->begun;
    picture->frame = ++p->frame;
    picture->complete = p->stage == STAGE_DONE && figures.missing == 0;
    picture->near_distance = paint_near_distance(&request.view);
    if (p->answered != p->begun) {
        p->answered = p->begun;
        p->latency_ms = stp_clock_ms() - p->begun_ms;
    }
    figures.latency_ms = p->latency_ms;
    picture->figures = figures;
    assert(p->painting != p->ready && p->ready != p->shown && p->shown != p->painting);
    int painted = p->painting;
    p->painting = p->ready;
    p->ready = painted;
    p->fresh = true;
    p->desc.wake(p->desc.user);
}

/// Opens the wanted file without the mutex, which is held on entry and exit.
static void open_scene(painter* p)
{
    char path[PATH_MAX];
    uint32_t serial = p->open_serial;
    snprintf(path, sizeof(path), "%s", p->open_path);
    p->opened_serial = serial;
    pthread_mutex_unlock(&p->mutex);
    paint_scene_desc desc = {.thread_count = p->desc.thread_count,
                             .memory_limit = p->desc.memory_limit,
                             .log = on_log,
                             .log_user = p};
    paint_scene* scene = paint_scene_open(&desc, path, serial);
    pthread_mutex_lock(&p->mutex);
    paint_scene* unseen = p->opened;
    p->opened = scene;
    pthread_mutex_unlock(&p->mutex);
    paint_scene_close(unseen);
    p->desc.wake(p->desc.user);
    pthread_mutex_lock(&p->mutex);
}

static void wait_for(painter* p, double milliseconds)
{
    struct timespec until;
    clock_gettime(CLOCK_MONOTONIC, &until);
    int64_t nanoseconds = (int64_t)until.tv_nsec + (int64_t)(1e6 * milliseconds);
    until.tv_sec += (time_t)(nanoseconds / 1000000000);
    until.tv_nsec = (long)(nanoseconds % 1000000000);
    pthread_cond_timedwait(&p->changed, &p->mutex, &until);
}

/// Switches to the requested scene; the previous one is no longer shown.
static bool take_scene(painter* p)
{
    if (p->current == NULL || p->request.scene != p->current->shown.serial) {
        return p->scene != NULL && p->request.scene == p->scene->shown.serial;
    }
    if (p->scene != p->current) {
        paint_scene* before = p->scene;
        p->scene = p->current;
        p->budget_ms = -1.0; // learn from scratch
        if (before != NULL) {
            pthread_mutex_unlock(&p->mutex);
            paint_scene_close(before);
            pthread_mutex_lock(&p->mutex);
        }
    }
    return true;
}

/// Applies the wanted visibility; the picture is redrawn.
static void take_list(painter* p)
{
    shown_list list = p->wanted_list;
    p->wanted_list = (shown_list){0};
    p->has_list = false;
    pthread_mutex_unlock(&p->mutex);
    (void)paint_scene_show(p->scene, &list); // failures are logged
    free(list.objects);
    pthread_mutex_lock(&p->mutex);
    p->begun = 0;
}

static void work(painter* p)
{
    if (p->open_serial != p->opened_serial) {
        open_scene(p);
    } else if (p->request.scene == 0 || !take_scene(p)) {
        pthread_cond_wait(&p->changed, &p->mutex);
    } else if (p->has_list && p->list_scene == p->scene->shown.serial) {
        take_list(p);
    } else if (p->begun != p->number) {
        p->begun = p->number;
        p->begun_ms = p->request_ms;
        p->stage = STAGE_MOVES;
        paint(p);
    } else if (p->stage != STAGE_DONE) {
        double since = stp_clock_ms() - p->request_ms;
        if (since < rest_ms) {
            wait_for(p, rest_ms - since + 1.0);
        } else {
            paint(p);
        }
    } else if (p->loads) {
        wait_for(p, loading_ms);
        p->stage = STAGE_RESTS;
    } else {
        pthread_cond_wait(&p->changed, &p->mutex);
    }
}

static void* run(void* user)
{
    painter* p = user;
    bool has_gl = p->desc.begin_gl != NULL && p->desc.begin_gl(p->desc.gl_user);
    p->gl_desc =
        (stp_draw_gl_desc){.get_proc_address = p->desc.get_proc_address, .user = p->desc.gl_user};
    if (has_gl) {
        (void)painter_gl_create(&p->gl, &p->gl_desc);
    }
    pthread_mutex_lock(&p->mutex);
    while (!p->quits) {
        work(p);
    }
    pthread_mutex_unlock(&p->mutex);
    paint_scene_close(p->scene); // on the thread that drew it
    painter_gl_destroy(&p->gl);
    if (has_gl) {
        p->desc.end_gl(p->desc.gl_user);
    }
    return NULL;
}

painter* painter_create(const painter_desc* desc)
{
    painter* p = calloc(1, sizeof(*p));
    if (p == NULL) {
        return NULL;
    }
    p->desc = *desc;
    p->ready = 1;
    p->shown = 2;
    pthread_condattr_t attributes;
    pthread_condattr_init(&attributes);
    pthread_condattr_setclock(&attributes, CLOCK_MONOTONIC);
    pthread_mutex_init(&p->mutex, NULL);
    pthread_cond_init(&p->changed, &attributes);
    pthread_condattr_destroy(&attributes);
    if (pthread_create(&p->thread, NULL, run, p) != 0) {
        pthread_mutex_destroy(&p->mutex);
        pthread_cond_destroy(&p->changed);
        free(p);
        return NULL;
    }
    return p;
}

void painter_destroy(painter* p)
{
    if (p == NULL) {
        return;
    }
    pthread_mutex_lock(&p->mutex);
    p->quits = true;
    abandon_refinement(p);
    pthread_cond_signal(&p->changed);
    pthread_mutex_unlock(&p->mutex);
    pthread_join(p->thread, NULL);
    paint_scene_close(p->opened);
    if (p->current != p->scene) {
        paint_scene_close(p->current);
    }
    free(p->wanted_list.objects);
    for (int i = 0; i < BUFFERS; ++i) {
        free(p->pictures[i].image.pixels);
        free(p->pictures[i].nearness);
    }
    pthread_mutex_destroy(&p->mutex);
    pthread_cond_destroy(&p->changed);
    free(p);
}

void painter_open(painter* p, const char* path, uint32_t serial)
{
    pthread_mutex_lock(&p->mutex);
    snprintf(p->open_path, sizeof(p->open_path), "%s", path);
    p->open_serial = serial;
    abandon_refinement(p);
    pthread_cond_signal(&p->changed);
    pthread_mutex_unlock(&p->mutex);
}

const painter_scene* painter_adopt(painter* p)
{
    pthread_mutex_lock(&p->mutex);
    paint_scene* scene = p->opened;
    paint_scene* passed_over = NULL;
    if (scene != NULL) {
        passed_over = p->current != p->scene ? p->current : NULL;
        p->opened = NULL;
        p->current = scene;
    }
    pthread_mutex_unlock(&p->mutex);
    paint_scene_close(passed_over);
    return scene != NULL ? &scene->shown : NULL;
}

void painter_show(painter* p, uint32_t scene, shown_list* list)
{
    pthread_mutex_lock(&p->mutex);
    free(p->wanted_list.objects);
    p->wanted_list = *list;
    p->list_scene = scene;
    p->has_list = true;
    p->number += 1; // forces a new picture even if the request is the same
    p->request_ms = stp_clock_ms();
    abandon_refinement(p);
    *list = (shown_list){0};
    pthread_cond_signal(&p->changed);
    pthread_mutex_unlock(&p->mutex);
}

uint64_t painter_request(painter* p, const paint_request* request)
{
    pthread_mutex_lock(&p->mutex);
    if (p->number == 0 || !paint_is_same_request(&p->request, request)) {
        p->request = *request;
        p->number += 1;
        p->request_ms = stp_clock_ms();
        abandon_refinement(p);
        pthread_cond_signal(&p->changed);
    }
    uint64_t number = p->number;
    pthread_mutex_unlock(&p->mutex);
    return number;
}

const painter_picture* painter_take(painter* p)
{
    const painter_picture* taken = NULL;
    pthread_mutex_lock(&p->mutex);
    if (p->fresh) {
        assert(p->painting != p->ready && p->ready != p->shown && p->shown != p->painting);
        int before = p->shown;
        p->shown = p->ready;
        p->ready = before;
        p->fresh = false;
        taken = &p->pictures[p->shown];
    }
    pthread_mutex_unlock(&p->mutex);
    return taken;
}

bool painter_get_message(painter* p, char* message, size_t size, bool* is_error)
{
    pthread_mutex_lock(&p->mutex);
    bool any = p->message[0] != 0;
    if (any) {
        snprintf(message, size, "%s", p->message);
        *is_error = p->message_is_error;
        p->message[0] = 0;
    }
    pthread_mutex_unlock(&p->mutex);
    return any;
}
