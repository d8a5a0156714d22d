// SPDX-License-Identifier: MIT
// Two OpenGL passes give a picture bit-identical to a single pass, for any previous
// picture.
#include "support_gl.h"
#include "tests.h"

#include "base/math/rng.h"
#include "draw/gl/gl_renderer.h"

#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE, SQUARES = 6, ROUNDS = 12, FRAMES = 4 };

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

/// A wall of triangles and one of splats, and squares of both kinds, most of them behind the
/// walls.
static void add_walls(made_picture* p)
{
    static const uint8_t colors[SQUARES][3] = {
        {230, 120, 30}, {30, 90, 220}, {40, 200, 60}, {200, 60, 20}, {220, 220, 60}, {120, 40, 160},
    };
    made_picture_add(p, 0.0, (stp_vec3d){-0.9, 0, 1.2}, NULL);
    made_picture_add(p, 0.0, (stp_vec3d){1.0, 0, 1.0}, colors[0]);
    for (uint64_t i = 0; i < SQUARES; ++i) {
        stp_vec3d at = {uniform(1, 10 * i, -2.0, 2.0), uniform(1, 10 * i + 1, -0.8, 0.8),
                        uniform(1, 10 * i + 2, -9.0, -2.0)};
        made_picture_add(p, uniform(1, 10 * i + 3, -1.2, 1.2), at, i % 3 == 0 ? NULL : colors[i]);
    }
    p->view.near_distance = 0.01;
}

/// The eye jumps, moves, then rests.
static void choose_view(made_picture* p, uint64_t round, int frame)
{
    double step = frame == 0 ? 1.5 : frame == 1 ? 0.2 : 0.0;
    p->view.eye = (stp_vec3d){uniform(round, 2, -1, 1) + step, uniform(round, 3, -1, 1),
                              uniform(round, 4, 2.5, 5.0) - 0.5 * step};
    p->view.target = (stp_vec3d){0.3 * step, 0, -1};
    p->view.fov_degrees = uniform(round, 5, 40.0, 70.0);
    p->quality.splat_size = (float)(1 + round % 4);
    p->style = (stp_draw_style){.supersample = 1 + (uint32_t)(round % 2)};
}

/// Commands postponed in the last sample: by the first pass, and by both.
static void read_aside(const made_gl* m, uint32_t aside[2])
{
    const stp_gl_renderer* r = (const stp_gl_renderer*)m->renderer;
    r->gl.GetNamedBufferSubData(r->occlusion.counters, 0, 2 * sizeof(uint32_t), aside);
}

void test_gl_occlusion_changes_no_pixel(test_state* test)
{
    static uint8_t whole[4 * PIXELS];
    made_gl m;
    bool failed;
    if (!made_gl_begin_with(&m, add_walls, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    stp_gl_renderer* r = (stp_gl_renderer*)m.renderer;
    uint32_t first = 0, both = 0, seen_after_all = 0;
    for (uint64_t round = 0; round < ROUNDS; ++round) {
        stp_gl_splats way = round % 3 == 0 ? STP_GL_SPLATS_COMPUTE : STP_GL_SPLATS_POINTS;
        stp_draw_gl_set_splats(m.renderer, way);
        for (int frame = 0; frame < FRAMES; ++frame) {
            uint32_t aside[2];
            choose_view(&m.picture, round, frame);
            r->omits.occlusion = true;
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(!r->occlusion.culls && m.picture.stats.draw_calls <= 4);
            memcpy(whole, m.pixels, sizeof(whole));
            r->omits.occlusion = false;
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(m.picture.stats.draw_calls <= 8);
            CHECK_EQUAL(0, memcmp(whole, m.pixels, sizeof(whole)));
            if (r->occlusion.culls) {
                read_aside(&m, aside);
                CHECK(aside[1] <= aside[0]);
                first += aside[0] > 0 ? 1 : 0;
                both += aside[1] > 0 ? 1 : 0;
                seen_after_all += aside[1] < aside[0] ? 1 : 0;
            }
        }
    }
    CHECK(first > ROUNDS && both > ROUNDS); // some commands were hidden
    CHECK(seen_after_all > 3);              // and some only by the previous picture
    made_gl_end(&m);
}

void test_gl_occlusion_leaves_out_undecided_groups(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin_with(&m, add_walls, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    stp_gl_renderer* r = (stp_gl_renderer*)m.renderer;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(r->occlusion.known && !r->occlusion.culls); // there was no previous picture
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(r->occlusion.culls);
    m.picture.style.filter = STP_FILTER_EWA; // it blends hidden splats too
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(!r->occlusion.culls);
    m.picture.style.filter = STP_FILTER_NONE;
    m.picture.view.ortho_height = 4;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(!r->occlusion.culls);
    m.picture.view.ortho_height = 0;
    m.picture.view.eye_distance = 0.1;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(!r->occlusion.culls && m.picture.stats.draw_calls <= 8);
    made_gl_end(&m);
}
