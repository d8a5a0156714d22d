// SPDX-License-Identifier: MIT
// Blended splats look the same with OpenGL and on the CPU.
#include "support_gl.h"
#include "tests.h"

#include "program/measure/image_compare.h"

#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE };

static const stp_filter filters[] = {STP_FILTER_EWA, STP_FILTER_BLEND};

static double compare(made_gl* m)
{
    stp_image a = {PICTURE_SIDE, PICTURE_SIDE, m->pixels};
    stp_image_quality quality;
    stp_result result =
        stp_image_compare(m->picture.context, &m->picture.image, &a, NULL, NULL, &quality);
    return result == STP_OK ? quality.ssim : 0.0;
}

void test_gl_filter_matches_the_cpu(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, false, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    m.picture.quality.splat_size = 5;
    for (int variant = 0; variant < 2; ++variant) {
        m.picture.view.ortho_height = variant == 1 ? 4 : 0;
        m.picture.style.filter = STP_FILTER_EWA;
        CHECK_EQUAL(STP_OK, made_picture_draw(&m.picture));
        CHECK(m.picture.stats.splats > 500);
        for (int i = 0; i < 2; ++i) {
            m.picture.style.filter = filters[i];
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(compare(&m) >= (i == 0 ? 0.999 : 0.99));
        }
        m.picture.style.filter = STP_FILTER_NONE;
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(compare(&m) < 0.97); // difficult: all sheets intersect
    }
    made_gl_end(&m);
}

// One plane of one colour: weights are divided by their sum.
void test_gl_filter_keeps_a_constant_colour(test_state* test)
{
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, true, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    made_picture* p = &m.picture;
    p->quality.splat_size = 7;
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    static uint8_t plain[4 * PIXELS];
    memcpy(plain, m.pixels, sizeof(plain));
    CHECK(p->stats.covered_pixels > 600 && p->stats.splats > 50);
    for (int i = 0; i < 2; ++i) {
        p->style.filter = filters[i];
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(made_count_different(plain, m.pixels, 1) == 0);
    }
    made_gl_end(&m);
}

// Splats hidden by splats too large for points have no effect.
void test_gl_blend_leaves_nothing_behind_large_splats(test_state* test)
{
    static const struct {
        float splat_size;
        double distance;
    } views[] = {{10, 0.3}, {10, 0.8}, {30, 0.8}, {20, 1.3}};
    made_gl m;
    bool failed;
    if (!made_gl_begin(&m, false, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    m.picture.quality.splats_only = true;
    made_picture* p = &m.picture;
    for (size_t i = 0; i < sizeof(views) / sizeof(views[0]); ++i) {
        p->quality.splat_size = views[i].splat_size;
        p->view.eye = (stp_vec3d){0.2, 0.1, views[i].distance};
        p->style.filter = STP_FILTER_EWA;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        p->style.filter = STP_FILTER_BLEND;
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(compare(&m) >= 0.98);
    }
    made_gl_end(&m);
}
