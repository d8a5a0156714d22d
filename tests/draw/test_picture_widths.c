// SPDX-License-Identifier: MIT
// Layers of glass in pictures whose width is no multiple of the size of tiles and marks.
#include "support_gl.h"
#include "tests.h"

#include "select/eyes.h"

#include <stdlib.h>
#include <string.h>

enum { HEIGHT = 48, WIDEST = 200, NARROW = 64, WIDTHS = 5 };

static const uint32_t widths[WIDTHS] = {65, 100, 127, 130, 193};

/// Two panes and a wall that cross the borders of tiles.
static void add_panes(made_picture* p)
{
    static const float wall[4] = {0.6f, 0.7f, 0.9f, 1.0f}, red[4] = {0.8f, 0.2f, 0.1f, 0.6f};
    static const float green[4] = {0.1f, 0.7f, 0.3f, 0.35f};
    made_picture_add_material(p, 1, wall);
    made_picture_add_material(p, 2, green);
    made_picture_add_material(p, 3, red);
    made_picture_add_sheet(p, 1, 0.5, (stp_vec3d){-0.9, 0.3, -1.0}, false);
    made_picture_add_sheet(p, 2, 0.2, (stp_vec3d){0.2, 0.1, 0.5}, false);
    made_picture_add_sheet(p, 3, 0.0, (stp_vec3d){0.7, -0.4, 1.0}, false);
    made_picture_add_sheet(p, 3, 0.3, (stp_vec3d){3.3, 0.4, 0.0}, false);
    made_picture_add_sheet(p, 2, 0.3, (stp_vec3d){-3.3, -0.4, 0.0}, false);
}

static stp_result draw(made_picture* p, stp_renderer* renderer, uint32_t width, double x,
                       uint8_t* pixels)
{
    stp_image image = {width, HEIGHT, pixels};
    p->view.width = width;
    p->view.height = HEIGHT;
    p->view.eye.x = p->view.target.x = x;
    return stp_renderer_draw_selected(renderer, &p->view, &p->quality, &p->style, &p->list, &image,
                                      &p->stats);
}

/// Pixels of two pictures, from a column of each on, that differ by more than two levels.
static int count_different(const uint8_t* a, uint32_t a_width, const uint8_t* b, uint32_t b_width,
                           uint32_t columns)
{
    uint32_t a_first = (a_width - columns) / 2, b_first = (b_width - columns) / 2;
    int different = 0;
    for (uint32_t i = 0; i < columns * HEIGHT; ++i) {
        const uint8_t* left = a + 4 * (i / columns * a_width + a_first + i % columns);
        const uint8_t* right = b + 4 * (i / columns * b_width + b_first + i % columns);
        bool differs = false;
        for (int c = 0; c < 4; ++c) {
            differs = differs || abs(left[c] - right[c]) > 2;
        }
        different += differs ? 1 : 0;
    }
    return different;
}

/// The middle of a wide picture is a narrow picture, whatever was drawn before.
void test_glass_of_any_width_has_the_same_layers(test_state* test)
{
    static uint8_t wide[WIDEST * HEIGHT * 4], narrow[NARROW * HEIGHT * 4];
    for (uint32_t threads = 1; threads <= 3; threads += 2) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, threads));
        add_panes(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (int i = 0; i < 2 * WIDTHS; ++i) {
            uint32_t width = widths[i % WIDTHS], columns = NARROW - width % 2;
            p.style.transparency = i < WIDTHS ? STP_TRANSPARENCY_LAYERS : STP_TRANSPARENCY_NEAREST;
            CHECK_EQUAL(STP_OK, draw(&p, p.renderer, columns, 0.1, narrow));
            CHECK_EQUAL(STP_OK, draw(&p, p.renderer, width, 1.3, wide)); // other tiles have glass
            CHECK_EQUAL(STP_OK, draw(&p, p.renderer, width, 0.1, wide));
            CHECK(p.stats.layers > 0);
            CHECK(count_different(wide, width, narrow, columns, columns) <= 2);
        }
        made_picture_end(&p);
    }
}

/// The picture of two eyes is that of each.
void test_glass_of_two_eyes_is_that_of_each(test_state* test)
{
    static uint8_t both[WIDEST * HEIGHT * 4], one[WIDEST * HEIGHT * 4];
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        made_picture p;
        CHECK(made_picture_begin(&p, NULL, threads));
        add_panes(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (int frame = 0; frame < 4; ++frame) {
            p.view.eye_distance = 0.3;
            CHECK_EQUAL(STP_OK, draw(&p, p.renderer, 130, 0.1 * frame, both));
            const stp_view view = p.view;
            for (uint32_t eye = 0; eye < 2; ++eye) {
                stp_image image = {65, HEIGHT, one};
                p.view = stp_view_of_eye(&view, eye);
                CHECK_EQUAL(STP_OK,
                            stp_renderer_draw_selected(p.renderer, &p.view, &p.quality, &p.style,
                                                       &p.list, &image, &p.stats));
                CHECK(p.stats.layers > 0);
                for (int y = 0; y < HEIGHT; ++y) {
                    CHECK_EQUAL(
                        0, memcmp(both + 4 * (y * 130 + 65 * (int)eye), one + 4 * y * 65, 4 * 65));
                }
            }
            p.view = view;
        }
        made_picture_end(&p);
    }
}

void test_gl_glass_of_any_width_matches_the_cpu(test_state* test)
{
    static uint8_t cpu[WIDEST * HEIGHT * 4], gl[WIDEST * HEIGHT * 4];
    bool failed;
    made_gl m;
    if (!made_gl_begin_with(&m, add_panes, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    for (int i = 0; i < 2 * WIDTHS; ++i) {
        uint32_t width = widths[i % WIDTHS];
        m.picture.style.pixel_filter = i >= WIDTHS;
        m.picture.view.eye_distance = width % 2 == 0 ? 0.3 : 0.0;
        CHECK_EQUAL(STP_OK, draw(&m.picture, m.picture.renderer, width, 0.1, cpu));
        CHECK_EQUAL(STP_OK, draw(&m.picture, m.renderer, width, 0.1, gl));
        CHECK(count_different(cpu, width, gl, width, width) <= (int)(width * HEIGHT / 100));
    }
    made_gl_end(&m);
}
