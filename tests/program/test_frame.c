// SPDX-License-Identifier: MIT
// The backend that draws if the OpenGL context lacks required functions.
#include "tests.h"

#include "draw/support_gl.h"
#include "program/drawing/frame.h"

#include <string.h>

/// Simulates a driver with fewer extensions: some functions are missing.
static void (*(*find_all)(const char* name))(void);
static void (*find_max(const char* name))(void)
{
    return strcmp(name, "glDispatchCompute") == 0 ? NULL : find_all(name);
}

static stp_result create(made_gl* m, frame_backend backend, stp_context* context,
                         frame_maker* maker)
{
    stp_headless headless;
    if (stp_headless_create(&(stp_headless_desc){0}, &headless) != NULL) {
        return STP_ERROR_IO;
    }
    find_all = headless.get_proc_address;
    headless.get_proc_address = find_max;
    return frame_maker_create_in(context, m->picture.store, &m->picture.style, backend, &headless,
                                 maker);
}

void test_frames_fall_back_to_the_cpu(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, true, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    stp_renderer_destroy(m.renderer); // replaced by another context
    m.renderer = NULL;
    made_picture* p = &m.picture;
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    frame_maker maker;
    frame_figures figures;
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, m.pixels};
    CHECK_EQUAL(STP_OK, create(&m, FRAME_BACKEND_AUTO, context, &maker));
    CHECK(strcmp(frame_backend_name(&maker), "cpu") == 0);
    CHECK_EQUAL(STP_OK, frame_draw(&maker, &p->view, &p->quality, &image, &figures));
    CHECK(figures.cost.covered_pixels > 100);
    frame_maker_destroy(&maker);
    // a request for OpenGL fails with the reason
    log.errors = 0;
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, create(&m, FRAME_BACKEND_GL, context, &maker));
    CHECK(log.errors == 1 && strstr(log.text, "glDispatchCompute") != NULL);
    frame_maker_destroy(&maker);
    stp_context_destroy(context);
    made_gl_end(&m);
}
