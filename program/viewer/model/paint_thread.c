// SPDX-License-Identifier: MIT
#include "program/viewer/model/paint_thread.h"

#include "base/core/clock.h"
#include "program/viewer/model/painter_scene.h"
#include "program/viewer/model/picture_memory.h"
#include "program/viewer/model/refinement.h"

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
    refinement refinement;
    bool loads; ///< data missing in the last frame is being loaded
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

/// The budget of the current scene and renderer.
static stp_budget* budget_of(painter* p)
{
    return &p->scene->budgets[p->uses_gl];
}

static void update_budget(painter* p, const paint_request* request, const paint_figures* f)
{
    if (request->budget_ms != p->budget_ms || request->controller != p->controller) {
        p->budget_ms = request->budget_ms;
        p->controller = request->controller;
        if (request->budget_ms > 0.0) {
            stp_budget_init(&p->scene->budgets[0], request->controller, request->budget_ms);
            stp_budget_init(&p->scene->budgets[1], request->controller, request->budget_ms);
            stp_budget_lower_resolution(&p->scene->budgets[0]); // of the CPU
        }
    }
    if (request->budget_ms > 0.0 && f != NULL) {
        stp_budget_update(budget_of(p), &f->cost);
    }
}

/// Adds OpenGL's timings of a finished frame to its figures. The budget learns CPU and GPU time.
static void measure_gl(painter* p, const paint_request* request, paint_figures* figures)
{
    const stp_frame_cost* sent = &figures->cost; // until commands were sent
    stp_draw_stats stats = {.layers = figures->layers,
                            .listed_splats = sent->splats,
                            .triangles = sent->triangles,
                            .listed_triangles = sent->listed_triangles,
                            .draw_calls = sent->draw_calls};
    stp_draw_gl_finish_stats(p->scene->renderers[1], &stats);
    figures->draw_ms = stats.draw_ms;
    figures->shade_ms = stats.shade_ms;
    figures->splats = stats.splats;
    double own_ms = sent->milliseconds + stats.draw_ms + stats.shade_ms;
    figures->cost = stp_draw_frame_cost(&request->style, &stats, sent->splat_size,
                                        fmin(figures->frame_ms, own_ms));
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
    if (!picture_memory_fit(picture, view->width, view->height)) {
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

/// Draws one frame with the size and style of its stage. A moving frame whose list is too long is
/// not drawn before it is coarser. @return as draw
static bool draw_stage(painter* p, paint_request* request, float* size, uint32_t* texture,
                       paint_figures* figures)
{
    const refinement* now = &p->refinement;
    const stp_draw_style whole = request->style;
    bool limited = request->budget_ms > 0.0 && now->stage == STAGE_MOVES && !p->uses_gl;
    bool accumulates = now->stage == STAGE_ACCUMULATES, drawn;
    double refused_ms = 0.0, refused_draw_ms = 0.0; // spent on frames that were given up
    request->quality.limit = limited ? stp_budget_limit(budget_of(p)) : (stp_work_limit){0};
    for (;;) {
        *size = refinement_size(now, request, budget_of(p));
        request->style = whole;
        request->style = refinement_style(now, request, budget_of(p), p->scene->transparent);
        drawn = draw(p, request, *size, accumulates, texture, figures);
        if (!drawn || !figures->exceeds) {
            break;
        }
        stp_budget_foresee(budget_of(p), &figures->cost);
        refused_ms += figures->frame_ms;
        refused_draw_ms += figures->draw_ms;
        request->quality.limit = (stp_work_limit){0};
    }
    figures->frame_ms += refused_ms;
    figures->draw_ms += refused_draw_ms;
    figures->select_ms += refused_ms - refused_draw_ms;
    figures->cost.milliseconds += refused_ms;
    return drawn;
}

/// Draws one frame without the mutex and makes it the ready picture. The mutex is held on entry and
/// exit.
static void paint(painter* p)
{
    paint_request request = p->request;
    painter_picture* picture = &p->pictures[p->painting];
    atomic_store(&p->stop, false);
    refinement* next = &p->refinement;
    p->refines = next->stage != STAGE_MOVES;
    pthread_mutex_unlock(&p->mutex);
    bool ready = paint_scene_color(p->scene, &request.points);
    paint_figures figures = {0};
    p->uses_gl = request.gl && !p->gl_lost && p->gl.functions != NULL && ready &&
                 paint_scene_use_gl(p->scene, &p->gl_desc, p->desc.gl_splats);
    paint_scene_set_stop(p->scene, p->refines ? &p->stop : NULL);
    update_budget(p, &request, NULL);
    float size = 1.0f;
    uint32_t texture = 0;
    const stp_draw_style whole = request.style;
    bool drawn = ready && draw_stage(p, &request, &size, &texture, &figures);
    next->left_out = !stp_draw_style_is_same(&whole, &request.style);
    if (ready && p->gl_lost && p->uses_gl) {
        on_log(STP_LOG_WARNING, "The OpenGL context was lost; using the CPU renderer from now on",
               p);
        p->uses_gl = false;
        request.style = whole;
        drawn = draw_stage(p, &request, &size, &texture, &figures);
        next->left_out = !stp_draw_style_is_same(&whole, &request.style);
    }
    if (drawn) {
        next->size = size / stp_draw_resolution(&request.style); // in pixels of the whole picture
        if (!p->refines) { // the budget does not learn from refinement, which uses another splat
                           // size and which nobody waits for
            update_budget(p, &request, &figures);
        }
        picture_memory_copy_depth(picture, stp_renderer_depth(p->scene->renderers[p->uses_gl]));
    }
    pthread_mutex_lock(&p->mutex);
    p->refines = false;
    if (!drawn) {
        // until the next request; an aborted refinement resumes with it
        next->stage = atomic_load(&p->stop) ? STAGE_RESTS : STAGE_DONE;
        return;
    }
    bool shows = refinement_shows(next, &request, figures.samples);
    refinement_advance(next, &request, budget_of(p), &figures);
    p->loads = figures.missing > 0;
    if (!shows) {
        return;
    }
    picture->view = request.view;
    picture->gl = p->uses_gl;
    picture->texture = texture;
    picture->scene = request.scene;
    picture->number = p->begun;
    picture->frame = ++p->frame;
    picture->complete = next->stage == STAGE_DONE && figures.missing == 0;
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
        p->refinement.stage = STAGE_MOVES;
        paint(p);
    } else if (p->refinement.stage != STAGE_DONE) {
        double since = stp_clock_ms() - p->request_ms;
        if (since < rest_ms) {
            wait_for(p, rest_ms - since + 1.0);
        } else {
            paint(p);
        }
    } else if (p->loads) {
        wait_for(p, loading_ms);
        p->refinement.stage = STAGE_RESTS;
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
        picture_memory_free(&p->pictures[i]);
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
