// SPDX-License-Identifier: MIT
// Square and textured splats: OpenGL pictures equal CPU pictures.
#include "support_gl.h"
#include "tests.h"

#include "program/measure/image_compare.h"

#include <string.h>

enum { PIXELS = PICTURE_SIDE * PICTURE_SIDE };

static bool begin(test_state* test, made_gl* m)
{
    bool begun = made_gl_begin_or_skip(test, m, NULL, NULL, NULL);
    m->picture.quality.splats_only = true;
    return begun;
}

/// Few splats, so that some are near or too large for points; or as many as fit.
static void look(made_picture* p, int variant)
{
    p->quality.splat_size = variant == 0 ? 4 : 40;
    p->view.eye = variant == 2 ? (stp_vec3d){0.2, 0.1, 0.5} : (stp_vec3d){0, 0, 5};
    p->view.ortho_height = variant == 3 ? 1.5 : 0;
}

static double compare(made_gl* m)
{
    stp_image a = {PICTURE_SIDE, PICTURE_SIDE, m->pixels};
    stp_image_quality quality;
    stp_result result =
        stp_image_compare(m->picture.context, &m->picture.image, &a, NULL, NULL, &quality);
    return result == STP_OK ? quality.ssim : 0.0;
}

void test_gl_squares_match_the_cpu(test_state* test)
{
    static const stp_gl_splats ways[] = {STP_GL_SPLATS_POINTS, STP_GL_SPLATS_COMPUTE};
    static uint8_t disks[4 * PIXELS];
    made_gl m;
    if (!begin(test, &m)) {
        return;
    }
    made_picture* p = &m.picture;
    for (int variant = 0; variant < 4; ++variant) {
        look(p, variant);
        p->style.splat_shape = STP_SPLAT_DISK;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        memcpy(disks, p->pixels, sizeof(disks));
        p->style.splat_shape = STP_SPLAT_SQUARE;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        CHECK(p->stats.splats > 5 && p->stats.covered_pixels > 300);
        CHECK(made_count_different(disks, p->pixels, 6) > 100);
        for (int i = 0; i < 2; ++i) {
            stp_draw_gl_set_splats(m.renderer, ways[i]);
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(made_count_different(m.pixels, p->pixels, 6) <= PIXELS / 100);
        }
    }
    p->style.splat_shape = STP_SPLAT_DISK; // and back
    CHECK_EQUAL(STP_OK, made_gl_draw(&m));
    CHECK(made_count_different(m.pixels, disks, 6) <= PIXELS / 100);
    made_gl_end(&m);
}

void test_gl_textured_splats_match_the_cpu(test_state* test)
{
    static uint8_t striped[4 * PIXELS];
    stp_splat_texture stripes;
    made_gl m;
    if (!begin(test, &m)) {
        return;
    }
    for (int i = 0; i < STP_SPLAT_TEXTURE_SIDE * STP_SPLAT_TEXTURE_SIDE; ++i) {
        stripes.texels[i] = i / STP_SPLAT_TEXTURE_SIDE % 16 < 8 ? 255 : 3;
    }
    made_picture* p = &m.picture;
    p->style.filter = STP_FILTER_TEXTURED;
    for (int variant = 0; variant < 4; ++variant) {
        p->quality.splat_size = variant < 2 ? 4 : 9;
        p->style.splat_texture = variant % 2 == 0 ? &stripes : NULL;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        CHECK(p->stats.splats > 50);
        memcpy(striped, variant % 2 == 0 ? p->pixels : striped, sizeof(striped));
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(compare(&m) >= (variant < 2 ? 0.99 : 0.97)); // as --filter blend is like ewa
        CHECK(variant % 2 == 0 || made_count_different(striped, p->pixels, 2) > 20);
    }
    made_gl_end(&m);
}
