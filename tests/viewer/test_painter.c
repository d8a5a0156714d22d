// SPDX-License-Identifier: MIT
// The thread that draws for the window: which requests make a new picture, and what happens when
// OpenGL is lost.
#include "support_boxes.h"
#include "tests.h"

#include "base/core/clock.h"
#include "program/present/headless.h"
#include "program/viewer/model/painter_scene.h"

#include <GL/glcorearb.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static void do_nothing(void* user)
{
    (void)user;
}

static bool begin_gl(void* user)
{
    return stp_headless_create(&(stp_headless_desc){.software = true}, user) == NULL;
}

static void end_gl(void* user)
{
    stp_headless_destroy(user);
}

static atomic_bool is_lost;

static GLenum answer_reset_status(void)
{
    return atomic_load(&is_lost) ? GL_INNOCENT_CONTEXT_RESET : GL_NO_ERROR;
}

static stp_gl_proc find_function(const char* name, void* user)
{
    return strcmp(name, "glGetGraphicsResetStatus") == 0
               ? (stp_gl_proc)answer_reset_status
               : stp_headless_get_proc_address(name, user);
}

static void rest(void)
{
    nanosleep(&(struct timespec){.tv_nsec = 2000000}, NULL);
}

static const painter_scene* adopt(painter* p)
{
    const painter_scene* scene;
    while ((scene = painter_adopt(p)) == NULL) {
        rest();
    }
    return scene;
}

static const painter_picture* wait_for(painter* p, uint64_t number)
{
    const painter_picture* picture;
    while ((picture = painter_take(p)) == NULL || picture->number != number || !picture->complete) {
        rest();
    }
    return picture;
}

/// The next picture of a request, complete or not.
static const painter_picture* wait_for_any(painter* p, uint64_t number)
{
    const painter_picture* picture;
    while ((picture = painter_take(p)) == NULL || picture->number != number) {
        rest();
    }
    return picture;
}

/// Moves the eye a little, and waits for the picture.
static const painter_picture* move_and_wait(painter* p, paint_request* request)
{
    request->view.eye.x += 0.01;
    return wait_for_any(p, painter_request(p, request));
}

static paint_request ask(bool gl)
{
    return (paint_request){.scene = 1,
                           .view = {.eye = {0.1, 0.1, 20},
                                    .up = {0, 1, 0},
                                    .fov_degrees = 40,
                                    .width = 100,
                                    .height = 80},
                           .samples = 1,
                           .gl = gl};
}

void test_viewer_painter_makes_another_picture_of_another_style(test_state* test)
{
    char path[64];
    CHECK(boxes_build("painter", path));
    painter_desc desc = {.thread_count = 1, .wake = do_nothing};
    painter* p = painter_create(&desc);
    CHECK(p != NULL);
    painter_open(p, path, 1);
    CHECK(adopt(p)->serial == 1);
    paint_request request = ask(false);
    uint64_t number = painter_request(p, &request);
    CHECK(number == painter_request(p, &request));
    CHECK(!wait_for(p, number)->gl);
    request.style.ghost = 0.5f;
    CHECK(painter_request(p, &request) == number + 1);
    CHECK(painter_request(p, &request) == number + 1);
    request.view.sections = (stp_sections){.count = 1, .planes = {{.normal = {1, 0, 0}}}};
    CHECK(painter_request(p, &request) == number + 2);
    (void)wait_for(p, number + 2);
    painter_destroy(p);
    unlink(path);
}

// A request that differs in any one member of its quality is another picture.
void test_viewer_painter_sees_every_change_of_quality(test_state* test)
{
    const stp_fovea fovea = {.count = 1, .zones = {{0.5f, 2.0f}}};
    stp_fovea moved = fovea, wider = fovea, coarser = fovea;
    moved.center[1] = 0.1f;
    wider.zones[0].radius = 0.6f;
    coarser.zones[0].factor = 3.0f;
    const stp_quality others[] = {
        {.splat_size = 2.0f, .fovea = fovea},
        {.splat_count = 5, .fovea = fovea},
        {.policy = STP_POLICY_PAPER, .fovea = fovea},
        {.method = 2, .fovea = fovea},
        {.reference = true, .fovea = fovea},
        {.splats_only = true, .fovea = fovea},
        {.nodes_only = true, .fovea = fovea},
        {.all_sides = true, .fovea = fovea},
        {.points_apart = true, .fovea = fovea},
        {.cues_off = 1, .fovea = fovea},
        {.early_switch = 2.0f, .fovea = fovea},
        {.fovea = {0}},
        {.fovea = moved},
        {.fovea = wider},
        {.fovea = coarser},
    };
    paint_request request = ask(false), other = request;
    request.quality = (stp_quality){.fovea = fovea};
    other.quality = request.quality;
    CHECK(paint_is_same_request(&request, &other));
    for (size_t i = 0; i < sizeof(others) / sizeof(others[0]); ++i) {
        other.quality = others[i];
        CHECK(!paint_is_same_request(&request, &other));
    }
}

static void say_nothing(stp_log_level level, const char* message, void* user)
{
    (void)level;
    (void)message;
    (void)user;
}

void test_viewer_painter_is_done_once_loaded_data_is_drawn(test_state* test)
{
    enum { BYTES = 4 * 100 * 80 };
    static uint8_t done[BYTES], again[BYTES];
    char path[64];
    CHECK(boxes_build("painter", path));
    paint_scene_desc desc = {.thread_count = 1, .memory_limit = 64 << 20, .log = say_nothing};
    paint_scene* s = paint_scene_open(&desc, path, 1);
    CHECK(s != NULL);
    paint_request request = ask(false);
    paint_figures figures = {.missing = 1};
    stp_image image = {100, 80, done};
    int frames = 0;
    for (; figures.missing > 0; ++frames) {
        (void)stp_residency_wait(s->residency); // everything requested is loaded
        CHECK_EQUAL(STP_OK, paint_scene_draw(s, &request, 1.0f, false, false, &image, &figures));
    }
    CHECK(frames > 1);
    image.pixels = again;
    CHECK_EQUAL(STP_OK, paint_scene_draw(s, &request, 1.0f, false, false, &image, &figures));
    CHECK(memcmp(done, again, BYTES) == 0);
    paint_scene_close(s);
    unlink(path);
}

enum { PICTURE_BYTES = 4 * 100 * 80 };

/// Stops a frame after some time.
typedef struct stopper {
    atomic_bool stop;
    atomic_int frame; ///< that picture is drawn
    int after_ms;
    int last_frame; ///< that picture may have begun before the stop
} stopper;

static void* stop_later(void* user)
{
    stopper* s = user;
    nanosleep(&(struct timespec){.tv_nsec = 1000000L * s->after_ms}, NULL);
    atomic_store(&s->stop, true);
    s->last_frame = atomic_load(&s->frame);
    return NULL;
}

/// Draws with a stop at once, or without. @return the result
static stp_result draw_scene(paint_scene* s, const paint_request* request, bool accumulates,
                             bool gl, uint8_t* pixels)
{
    paint_figures figures;
    stp_image image = {100, 80, pixels};
    return paint_scene_draw(s, request, 1.0f, accumulates, gl, &image, &figures);
}

/// Aborted frames end soon and do not affect later ones.
static void abandon_frames(test_state* test, paint_scene* s, const paint_request* request, bool gl)
{
    static uint8_t wanted[PICTURE_BYTES], got[PICTURE_BYTES];
    paint_request long_one = *request;
    paint_scene_set_stop(s, NULL);
    CHECK_EQUAL(STP_OK, draw_scene(s, request, false, gl, wanted));
    long_one.style.supersample = gl ? 8 : 64;
    for (int i = 0; i < 6; ++i) {
        stopper stopping = {.after_ms = 3 * i * i};
        pthread_t thread;
        atomic_init(&stopping.stop, i == 0);
        atomic_init(&stopping.frame, 0);
        paint_scene_set_stop(s, &stopping.stop);
        CHECK(pthread_create(&thread, NULL, stop_later, &stopping) == 0);
        stp_result result = STP_OK;
        for (int k = 0; k < 4096 && result == STP_OK; ++k) { // or one long frame
            atomic_store(&stopping.frame, k);
            result = i % 2 == 1 ? draw_scene(s, request, true, gl, got)
                                : draw_scene(s, &long_one, false, gl, got);
        }
        CHECK_EQUAL(STP_ERROR_CANCELLED, result);
        pthread_join(thread, NULL);
        CHECK(atomic_load(&stopping.frame) <= stopping.last_frame + 1);
        atomic_store(&stopping.stop, false);
        CHECK_EQUAL(STP_OK, draw_scene(s, request, false, gl, got));
        CHECK(memcmp(wanted, got, PICTURE_BYTES) == 0);
        paint_scene_set_stop(s, NULL);
    }
}

static const stp_draw_style abandoned_styles[] = {
    {.background = true},
    {.ambient_occlusion = 0.04f, .eye_dome = 1.0f},
    {.filter = STP_FILTER_EWA},
};
enum { ABANDONED_STYLES = sizeof(abandoned_styles) / sizeof(abandoned_styles[0]) };

void test_viewer_painter_abandons_cpu_frames(test_state* test)
{
    char path[64];
    CHECK(boxes_build("painter", path));
    paint_scene_desc desc = {.thread_count = 2, .log = say_nothing};
    paint_scene* s = paint_scene_open(&desc, path, 1);
    CHECK(s != NULL);
    paint_request request = ask(false);
    request.samples = 64;
    for (int i = 0; i < ABANDONED_STYLES; ++i) {
        request.style = abandoned_styles[i];
        abandon_frames(test, s, &request, false);
    }
    paint_scene_close(s);
    unlink(path);
}

void test_viewer_painter_abandons_gl_frames(test_state* test)
{
    char path[64];
    stp_headless headless;
    if (!begin_gl(&headless)) {
        SKIP("there is no OpenGL");
    }
    CHECK(boxes_build("painter", path));
    paint_scene_desc desc = {.thread_count = 2, .log = say_nothing};
    stp_draw_gl_desc gl = {.get_proc_address = stp_headless_get_proc_address, .user = &headless};
    paint_scene* s = paint_scene_open(&desc, path, 1);
    CHECK(s != NULL && paint_scene_use_gl(s, &gl, STP_GL_SPLATS_POINTS));
    paint_request request = ask(true);
    request.samples = 64;
    for (int i = 0; i < ABANDONED_STYLES; ++i) {
        request.style = abandoned_styles[i];
        abandon_frames(test, s, &request, true);
    }
    paint_scene_close(s);
    end_gl(&headless);
    unlink(path);
}

static void sleep_ms(double ms)
{
    double end = stp_clock_ms() + ms;
    while (stp_clock_ms() < end) {
        rest();
    }
}

/// After a rest with refinement, a moving camera continues with the budget's last splat size.
void test_viewer_painter_keeps_the_budget_while_it_refines(test_state* test)
{
    char path[64];
    CHECK(boxes_build("painter", path));
    painter_desc desc = {.thread_count = 1, .wake = do_nothing};
    painter* p = painter_create(&desc);
    CHECK(p != NULL);
    painter_open(p, path, 1);
    (void)adopt(p);
    paint_request request = ask(false);
    const painter_picture* picture;
    float size = 0.0f;
    request.style.supersample = 6;
    request.budget_ms = 0.1; // too little for any size
    for (int i = 0; i < 8; ++i) {
        picture = move_and_wait(p, &request);
        size = i < 7 ? (float)stp_frame_splat_size(&picture->figures.cost) : size;
        if (i == 6) {
            picture = wait_for(p, picture->number);
            CHECK(picture->figures.cost.splat_size < 1.05f);
            CHECK(stp_frame_resolution(&picture->figures.cost) == 1.0);
        }
    }
    CHECK(size > 2.0f && stp_frame_splat_size(&picture->figures.cost) > 0.8 * (double)size);
    painter_destroy(p);
    unlink(path);
}

/// Effects that a moving camera has no time for are in the first picture at rest, with fine splats.
void test_viewer_painter_takes_effects_back_at_rest(test_state* test)
{
    char path[64];
    CHECK(boxes_build("painter", path));
    painter_desc desc = {.thread_count = 1, .wake = do_nothing};
    painter* p = painter_create(&desc);
    CHECK(p != NULL);
    painter_open(p, path, 1);
    (void)adopt(p);
    paint_request request = ask(false);
    const painter_picture* picture = NULL;
    request.style.ambient_occlusion = 0.05f;
    request.budget_ms = 0.1; // too little for any effect
    uint64_t frame = 0;
    for (int i = 0; i < 8; ++i) {
        picture = move_and_wait(p, &request);
        frame = picture->frame;
        bool occluded = picture->figures.cost.effect_ms[STP_EFFECT_OCCLUSION] > 0.0;
        CHECK(i < 5 ? i > 2 || occluded : !occluded); // judged after three frames
    }
    CHECK(picture->figures.cost.splat_size > 1.5f && !picture->complete);
    while ((picture = painter_take(p)) == NULL || picture->frame == frame) {
        rest();
    }
    CHECK(picture->figures.cost.effect_ms[STP_EFFECT_OCCLUSION] > 0.0);
    if (!picture->complete) { // splats shrink in steps on a busy machine
        picture = wait_for(p, picture->number);
    }
    CHECK(picture->figures.cost.splat_size < 1.05f);
    painter_destroy(p);
    unlink(path);
}

/// When the camera moves again after a rest, its picture does not wait for the refinement in
/// progress.
void test_viewer_painter_answers_while_it_refines(test_state* test)
{
    char path[64];
    CHECK(boxes_build("painter", path));
    painter_desc desc = {.thread_count = 1, .wake = do_nothing};
    painter* p = painter_create(&desc);
    CHECK(p != NULL);
    painter_open(p, path, 1);
    CHECK(adopt(p)->serial == 1);
    int waited = 0; // a refinement may end just before the request
    for (int i = 0; i < 6; ++i) {
        paint_request slow = ask(false), quick = ask(false);
        const painter_picture* picture;
        slow.style.supersample = 24; // refinement is as slow as the first picture
        slow.budget_ms = 500.0;
        slow.view.eye.x += 0.01 * i;
        uint64_t old = painter_request(p, &slow);
        double slow_ms = wait_for_any(p, old)->figures.frame_ms;
        sleep_ms((0.2 + 0.45 * i) * slow_ms);
        quick.view.eye.y += 0.01 * (i + 1);
        (void)painter_take(p);
        uint64_t number = painter_request(p, &quick);
        bool refined = false; // after the request
        while ((picture = painter_take(p)) == NULL || picture->number != number) {
            refined |= picture != NULL && picture->number == old && picture->complete;
            rest();
        }
        waited += refined ? 1 : 0;
    }
    CHECK(waited < 4);
    painter_destroy(p);
    unlink(path);
}

static bool has_gl(stp_headless* headless)
{
    bool has = begin_gl(headless);
    if (has) {
        end_gl(headless);
    }
    return has;
}

/// A painter that draws a file with OpenGL and these functions. NULL: out of memory.
static painter* open_with_gl(const char* path, stp_headless* headless,
                             stp_gl_proc (*find)(const char* name, void* user))
{
    painter_desc desc = {.thread_count = 1,
                         .wake = do_nothing,
                         .begin_gl = begin_gl,
                         .end_gl = end_gl,
                         .get_proc_address = find,
                         .gl_user = headless};
    painter* p = painter_create(&desc);
    if (p != NULL) {
        painter_open(p, path, 1);
        (void)adopt(p);
    }
    return p;
}

void test_viewer_painter_draws_on_where_opengl_is_lost(test_state* test)
{
    char path[64], message[512] = "";
    stp_headless headless;
    bool is_error = true;
    if (!has_gl(&headless)) {
        SKIP("there is no OpenGL");
    }
    CHECK(boxes_build("painter", path));
    atomic_store(&is_lost, false);
    painter* p = open_with_gl(path, &headless, find_function);
    CHECK(p != NULL);
    paint_request request = ask(true);
    const painter_picture* picture = wait_for(p, painter_request(p, &request));
    CHECK(picture->gl && picture->texture != 0);
    const paint_figures* f = &picture->figures; // figures of this frame, although no file was read
    CHECK(f->cost.covered_pixels > 100 && f->draw_ms > 0.0 && f->shade_ms > 0.0);
    CHECK(f->cost.milliseconds <= f->frame_ms);
    CHECK(f->cost.milliseconds + 1e-9 >= fmin(f->frame_ms, f->draw_ms + f->shade_ms));
    CHECK(!painter_get_message(p, message, sizeof(message), &is_error));
    atomic_store(&is_lost, true);
    for (int i = 0; i < 2; ++i) { // from then on
        request.view.eye.x += 0.5;
        picture = wait_for(p, painter_request(p, &request));
        CHECK(!picture->gl && picture->texture == 0 && picture->figures.cost.covered_pixels > 100);
        CHECK(painter_get_message(p, message, sizeof(message), &is_error) == (i == 0));
    }
    CHECK(!is_error && strstr(message, "using the CPU renderer") != NULL);
    painter_destroy(p);
    unlink(path);
}

static atomic_int slow_finishes;
static stp_gl_proc real_finish;

/// glFinish of a driver that compiles in the first frame.
static void finish_slowly(void)
{
    if (atomic_fetch_sub(&slow_finishes, 1) > 0) {
        sleep_ms(1600.0);
    }
    real_finish();
}

static stp_gl_proc find_slow_function(const char* name, void* user)
{
    stp_gl_proc function = stp_headless_get_proc_address(name, user);
    if (strcmp(name, "glFinish") != 0) {
        return function;
    }
    real_finish = function;
    return (stp_gl_proc)finish_slowly;
}

/// The duration of the first frame does not decide whether samples are accumulated.
void test_viewer_painter_accumulates_after_a_slow_frame(test_state* test)
{
    char path[64];
    stp_headless headless;
    if (!has_gl(&headless)) {
        SKIP("there is no OpenGL");
    }
    CHECK(boxes_build("painter", path));
    atomic_store(&slow_finishes, 1);
    painter* p = open_with_gl(path, &headless, find_slow_function);
    CHECK(p != NULL);
    paint_request request = ask(true);
    request.samples = 2;
    const painter_picture* picture = wait_for(p, painter_request(p, &request));
    CHECK(atomic_load(&slow_finishes) <= 0 && picture->gl);
    CHECK_EQUAL(4, (int)picture->figures.samples);
    painter_destroy(p);
    unlink(path);
}
