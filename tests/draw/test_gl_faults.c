// SPDX-License-Identifier: MIT
// Errors of a context are reported once, in one sentence.
#include "support_gl.h"
#include "tests.h"

#include "draw/gl/gl_renderer.h"

#include <string.h>

/// An OpenGL context in which some functions return wrong results.
typedef struct faulty {
    made_gl made;
    stp_context* context; ///< its log has the errors
    test_log log;
    const char* lacks; ///< name of a missing function
} faulty;

/// Results of replaced functions, which have no user pointer.
static GLenum lost_status(void)
{
    return GL_GUILTY_CONTEXT_RESET;
}

/// Every second result: the first query is for earlier errors.
static GLenum no_memory(void)
{
    static int calls;
    return calls++ % 2 == 0 ? GL_NO_ERROR : GL_OUT_OF_MEMORY;
}

static stp_gl_proc find_function(const char* name, void* user)
{
    faulty* f = user;
    bool lacking = f->lacks != NULL && strcmp(name, f->lacks) == 0;
    return lacking ? NULL : stp_headless_get_proc_address(name, &f->made.headless);
}

/// @return false if OpenGL is not available
static bool begin(test_state* test, faulty* f)
{
    bool failed;
    *f = (faulty){.lacks = NULL};
    if (!made_gl_begin(&f->made, false, &failed)) {
        made_gl_end(&f->made);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return false;
    }
    stp_renderer_destroy(f->made.renderer);
    f->made.renderer = NULL;
    f->context = test_context(NULL, 1, &f->log);
    return true;
}

void test_gl_contexts_report_their_loss(test_state* test)
{
    stp_headless headless;
    if (stp_headless_create(&(stp_headless_desc){.software = true}, &headless) != NULL) {
        test->skipped = "there is no OpenGL";
        return;
    }
    PFNGLGETINTEGERVPROC get =
        (PFNGLGETINTEGERVPROC)stp_headless_get_proc_address("glGetIntegerv", &headless);
    GLint strategy = 0;
    get(GL_RESET_NOTIFICATION_STRATEGY, &strategy);
    CHECK_EQUAL(GL_LOSE_CONTEXT_ON_RESET, strategy);
    stp_headless_destroy(&headless);
}

static stp_result make(faulty* f)
{
    const stp_draw_gl_desc desc = {.get_proc_address = find_function, .user = f, .debug = true};
    return stp_draw_gl_create(f->context, f->made.picture.store, &desc, &f->made.renderer);
}

/// The list and its memory belong to the picture.
static stp_result draw(faulty* f)
{
    made_picture* p = &f->made.picture;
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, f->made.pixels};
    stp_result result = stp_select(p->context, p->store, &p->view, &p->quality, &p->list);
    return result == STP_OK ? stp_renderer_draw(f->made.renderer, &p->view, &p->list, &p->style,
                                                &image, &p->stats)
                            : result;
}

static void end(faulty* f)
{
    if (f->made.renderer != NULL) {
        stp_renderer_destroy(f->made.renderer);
        f->made.renderer = NULL;
    }
    stp_context_destroy(f->context);
    made_gl_end(&f->made);
}

void test_gl_names_missing_features(test_state* test)
{
    faulty f;
    if (!begin(test, &f)) {
        return;
    }
    f.lacks = "glDispatchCompute";
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, make(&f));
    CHECK(f.made.renderer == NULL && f.log.errors == 1);
    CHECK(strstr(f.log.text, "glDispatchCompute") != NULL && strstr(f.log.text, "4.5") != NULL);
    end(&f);
}

void test_gl_reports_a_lost_context(test_state* test)
{
    faulty f;
    if (!begin(test, &f)) {
        return;
    }
    CHECK_EQUAL(STP_OK, make(&f));
    CHECK_EQUAL(STP_OK, draw(&f));
    stp_gl_renderer* r = (stp_gl_renderer*)f.made.renderer;
    r->gl.GetGraphicsResetStatus = lost_status;
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, draw(&f));
    CHECK_EQUAL(1, f.log.errors);
    CHECK(strstr(f.log.text, "lost") != NULL && strstr(f.log.text, "create the context") != NULL);
    end(&f);
}

void test_gl_reports_lack_of_graphics_memory(test_state* test)
{
    faulty f;
    if (!begin(test, &f)) {
        return;
    }
    CHECK_EQUAL(STP_OK, make(&f));
    stp_gl_renderer* r = (stp_gl_renderer*)f.made.renderer;
    PFNGLGETERRORPROC get_error = r->gl.GetError;
    CHECK_EQUAL(STP_OK, draw(&f));
    f.made.picture.view.width = 3; // another target
    stp_image image = {3, PICTURE_SIDE, f.made.pixels};
    made_picture* p = &f.made.picture;
    r->gl.GetError = no_memory;
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_renderer_draw(f.made.renderer, &p->view, &p->list,
                                                           &p->style, &image, &p->stats));
    CHECK(f.log.errors == 1 && strstr(f.log.text, "3x64") != NULL);
    r->gl.GetError = get_error;
    CHECK_EQUAL(STP_OK, stp_renderer_draw(f.made.renderer, &p->view, &p->list, &p->style, &image,
                                          &p->stats));
    end(&f);
}

/// Without memory for the pixel filter, pictures are drawn without it, with one warning.
void test_gl_without_memory_for_the_filter_draws_without_it(test_state* test)
{
    static uint8_t plain[PICTURE_SIDE * PICTURE_SIDE * 4];
    faulty f;
    if (!begin(test, &f)) {
        return;
    }
    CHECK_EQUAL(STP_OK, make(&f));
    stp_gl_renderer* r = (stp_gl_renderer*)f.made.renderer;
    PFNGLGETERRORPROC get_error = r->gl.GetError;
    CHECK_EQUAL(STP_OK, draw(&f));
    memcpy(plain, f.made.pixels, sizeof(plain));
    f.made.picture.style.pixel_filter = true;
    r->gl.GetError = no_memory;
    for (int i = 0; i < 2; ++i) {
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK_EQUAL(0, made_count_different(plain, f.made.pixels, 0));
        CHECK(f.log.errors == 0 && f.log.warnings == 1);
    }
    CHECK(strstr(f.log.warning, "64x64") != NULL);
    r->gl.GetError = get_error;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(made_count_different(plain, f.made.pixels, 0) > 0);
    end(&f);
}

void test_gl_fails_where_a_debug_context_complains(test_state* test)
{
    faulty f;
    if (!begin(test, &f)) {
        return;
    }
    CHECK_EQUAL(STP_OK, make(&f));
    CHECK_EQUAL(STP_OK, draw(&f));
    stp_gl_renderer* r = (stp_gl_renderer*)f.made.renderer;
    r->gl.Enable(GL_TEXTURE_BUFFER_BINDING); // not a capability
    CHECK_EQUAL(STP_ERROR_UNSUPPORTED, draw(&f));
    CHECK(f.log.errors == 1 && strncmp(f.log.text, "gl: ", 4) == 0);
    CHECK_EQUAL(STP_OK, draw(&f)); // once
    end(&f);
}

void test_gl_restores_the_context_as_documented(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, false, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    const stp_gl_renderer* r = (const stp_gl_renderer*)m.renderer;
    static const struct {
        GLenum name;
        GLint value;
    } states[] = {{GL_CURRENT_PROGRAM, 0},
                  {GL_VERTEX_ARRAY_BINDING, 0},
                  {GL_DRAW_FRAMEBUFFER_BINDING, 0},
                  {GL_DRAW_INDIRECT_BUFFER_BINDING, 0},
                  {GL_PIXEL_PACK_BUFFER_BINDING, 0},
                  {GL_DEPTH_TEST, 0},
                  {GL_DEPTH_FUNC, GL_LESS},
                  {GL_PROGRAM_POINT_SIZE, 0},
                  {GL_CLIP_DEPTH_MODE, GL_NEGATIVE_ONE_TO_ONE},
                  {GL_CLIP_ORIGIN, GL_LOWER_LEFT}};
    for (size_t i = 0; i < sizeof(states) / sizeof(states[0]); ++i) {
        GLint value = -1;
        r->gl.GetIntegerv(states[i].name, &value);
        CHECK_EQUAL(states[i].value, value);
    }
    made_gl_end(&m);
}
