// SPDX-License-Identifier: MIT
// Splats drawn by compute shaders give the same picture as points and as the CPU.
#include "support_gl.h"
#include "tests.h"

#include "draw/gl/gl_renderer.h"

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE };

typedef struct visible {
    uint32_t ids[PIXELS];
    float nearness[PIXELS];
} visible;

static void read_visible(made_gl* m, visible* v)
{
    const stp_gl_renderer* r = (const stp_gl_renderer*)m->renderer;
    stp_gl_read_texture(&r->gl, r->target.ids, GL_RED_INTEGER, GL_UNSIGNED_INT, PICTURE_SIDE,
                        PICTURE_SIDE, sizeof(v->ids), v->ids);
    stp_gl_read_texture(&r->gl, r->target.nearness, GL_DEPTH_COMPONENT, GL_FLOAT, PICTURE_SIDE,
                        PICTURE_SIDE, sizeof(v->nearness), v->nearness);
}

static int count_other_ids(const visible* a, const visible* b)
{
    int count = 0;
    for (int i = 0; i < PIXELS; ++i) {
        count += a->ids[i] != b->ids[i] || a->nearness[i] != b->nearness[i] ? 1 : 0;
    }
    return count;
}

static void compare_ways(test_state* test, made_gl* m)
{
    static visible points, compute;
    stp_draw_gl_set_splats(m->renderer, STP_GL_SPLATS_POINTS);
    CHECK_EQUAL(STP_OK, made_gl_draw(m));
    bool any = m->picture.stats.splats > 0;
    CHECK(!any || stp_draw_gl_get_stats(m->renderer).splats == STP_GL_SPLATS_POINTS);
    CHECK(m->picture.stats.covered_pixels > 400);
    read_visible(m, &points);
    stp_draw_gl_set_splats(m->renderer, STP_GL_SPLATS_COMPUTE);
    CHECK_EQUAL(STP_OK, made_gl_draw(m));
    CHECK(!any || stp_draw_gl_get_stats(m->renderer).splats == STP_GL_SPLATS_COMPUTE);
    read_visible(m, &compute);
    int others = count_other_ids(&points, &compute);
    CHECK(others <= PIXELS / 200);
    CHECK_EQUAL(STP_OK, made_picture_draw(&m->picture));
    CHECK(made_count_different(m->pixels, m->picture.pixels, 6) <= PIXELS / 50);
}

void test_gl_raster_gives_the_picture_of_points(test_state* test)
{
    static const float sizes[] = {4, 12, 40};
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, false, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    for (int variant = 0; variant < 3; ++variant) {
        m.picture.view.ortho_height = variant == 1 ? 4 : 0;
        m.picture.view.eye = (stp_vec3d){0.4, -0.3, variant == 2 ? 1.2 : 5};
        for (int i = 0; i < 3; ++i) {
            m.picture.quality.splat_size = sizes[i];
            compare_ways(test, &m);
        }
    }
    m.picture.view.eye = (stp_vec3d){0.4, -0.3, 5};
    m.picture.quality.splat_size = 4; // many large splats
    m.picture.quality.splat_count = 400;
    compare_ways(test, &m);
    made_gl_end(&m);
}

void test_gl_splats_are_chosen_by_measuring(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, false, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    m.picture.quality.splat_size = 3;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    stp_gl_splats used = stp_draw_gl_get_stats(m.renderer).splats;
    stp_draw_gl_speed speed = stp_draw_gl_get_speed(m.renderer);
    CHECK(used != STP_GL_SPLATS_AUTO);
    for (int way = 0; way < 2; ++way) {
        for (int i = 0; i < STP_GL_SPLAT_SIZES; ++i) {
            CHECK(speed.splat_ns[way][i] > 0 && speed.splat_ns[way][i] < 1e7);
        }
    }
    CHECK(speed.fixed_ns[0] == 0 && speed.fixed_ns[1] > 0);
    // many splats of one size are drawn by the cheapest way
    stp_gl_renderer* r = (stp_gl_renderer*)m.renderer;
    for (int i = 0; i < STP_GL_SPLAT_SIZES; ++i) {
        bool points = speed.splat_ns[0][i] <= speed.splat_ns[1][i];
        stp_gl_splats way = stp_gl_splat_choice_find(r, UINT64_C(1) << 40, speed.sizes[i]);
        CHECK(points == (way == STP_GL_SPLATS_POINTS));
    }
    CHECK_EQUAL(STP_GL_SPLATS_POINTS, stp_gl_splat_choice_find(r, 0, 1));
    // the picture is not the measured one
    CHECK_EQUAL(STP_OK, made_picture_draw(&m.picture));
    CHECK(made_count_different(m.pixels, m.picture.pixels, 6) <= PIXELS / 50);
    made_gl_end(&m);
}
