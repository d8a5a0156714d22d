// SPDX-License-Identifier: MIT
// The thread that draws for the window: what makes another picture, and what happens when OpenGL is lost.
#include "tests.h"

#include "present/headless.h"
#include "viewer/painter_scene.h"
#include "viewer/support_boxes.h"

#include <GL/glcorearb.h>
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

static void say_nothing(stp_log_level level, const char* message, void* user)
{
    (void)level;
    (void)message;
    (void)user;
}

void test_viewer_painter_is_done_once_what_came_is_drawn(test_state* test)
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
        (void)stp_residency_wait(s->residency); // all that was asked for is there
        CHECK_EQUAL(STP_OK, paint_scene_draw(s, &request, 1.0f, false, false, &image, &figures));
    }
    CHECK(frames > 1);
    image.pixels = again;
    CHECK_EQUAL(STP_OK, paint_scene_draw(s, &request, 1.0f, false, false, &image, &figures));
    CHECK(memcmp(done, again, BYTES) == 0);
    paint_scene_close(s);
    unlink(path);
}

void test_viewer_painter_draws_on_where_opengl_is_lost(test_state* test)
{
    char path[64], message[512] = "";
    stp_headless headless;
    bool is_error = true;
    if (!begin_gl(&headless)) {
        SKIP("there is no OpenGL");
    }
    end_gl(&headless);
    CHECK(boxes_build("painter", path));
    painter_desc desc = {.thread_count = 1,
                         .wake = do_nothing,
                         .begin_gl = begin_gl,
                         .end_gl = end_gl,
                         .get_proc_address = find_function,
                         .gl_user = &headless};
    atomic_store(&is_lost, false);
    painter* p = painter_create(&desc);
    CHECK(p != NULL);
    painter_open(p, path, 1);
    (void)adopt(p);
    paint_request request = ask(true);
    const painter_picture* picture = wait_for(p, painter_request(p, &request));
    CHECK(picture->gl && picture->texture != 0);
    const paint_figures* f = &picture->figures; // of this frame, though nothing was read
    CHECK(f->covered_pixels > 100 && f->draw_ms > 0.0 && f->shade_ms > 0.0);
    CHECK(f->work_ms <= f->frame_ms);
    CHECK(f->work_ms + 1e-9 >= fmin(f->frame_ms, f->draw_ms + f->shade_ms));
    CHECK(!painter_get_message(p, message, sizeof(message), &is_error));
    atomic_store(&is_lost, true);
    for (int i = 0; i < 2; ++i) { // from then on
        request.view.eye.x += 0.5;
        picture = wait_for(p, painter_request(p, &request));
        CHECK(!picture->gl && picture->texture == 0 && picture->figures.covered_pixels > 100);
        CHECK(painter_get_message(p, message, sizeof(message), &is_error) == (i == 0));
    }
    CHECK(!is_error && strstr(message, "using the CPU renderer") != NULL);
    painter_destroy(p);
    unlink(path);
}
