// SPDX-License-Identifier: MIT
// Points of a fixed size, in pixels or scene units, on both backends; and normals of unknown sign.
#include "support_gl.h"
#include "tests.h"

#include <math.h>
#include <string.h>

static const uint8_t red[3] = {255, 0, 0}, green[3] = {0, 255, 0};

enum { POINTS = 16 };

/// Sixteen points, half a unit apart, far and near: a quarter of a square's splats per distance.
static void add_points(made_picture* p)
{
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, red);
    made_scene* s = &p->scene;
    stp_store_node* node = &s->nodes[s->node_count - 1];
    stp_splats* set = &s->sets[s->set_count - 1];
    made_free_set(p->context, set);
    *set = made_square_set(p->context, 2, red);
    node->triangle_count = 0;
    node->point_count = POINTS;
    node->part_count = 0;
}

static uint32_t count_covered(const uint8_t* pixels)
{
    uint32_t count = 0;
    for (int i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        count += pixels[4 * i + 3] != 0;
    }
    return count;
}

/// Number of pixels that the points cover from a distance; 0 if they cannot be drawn.
static uint32_t covered_from(made_picture* p, double distance)
{
    p->view.eye.z = distance;
    return made_picture_draw(p) == STP_OK ? count_covered(p->pixels) : 0;
}

static bool is_about(uint32_t found, double wanted)
{
    return fabs((double)found - wanted) <= 0.2 * wanted;
}

static void check_sizes(test_state* test, made_picture* p)
{
    const double disk = 0.25 * 3.14159265358979;
    p->style.point_sizing = STP_POINTS_PIXELS;
    p->style.point_size = 6.0f;
    CHECK(is_about(covered_from(p, 5.0), POINTS * disk * 36.0));
    CHECK(
        is_about(covered_from(p, 7.0), POINTS * disk * 36.0)); // the same number from farther away
    p->style.point_size = 1.0f;
    CHECK_EQUAL(POINTS, covered_from(p, 5.0)); // the pixels of their centres
    p->style.point_sizing = STP_POINTS_UNITS;
    p->style.point_size = 0.4f; // 16 pixels per unit at distance 5
    uint32_t near = covered_from(p, 5.0), far = covered_from(p, 10.0);
    CHECK(is_about(near, POINTS * disk * 6.4 * 6.4));
    CHECK(far > near / 6 && far < near / 2);
    p->view.eye.z = 5.0;
}

void test_points_have_fixed_sizes(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 2));
    add_points(&p);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    check_sizes(test, &p);
    for (int ortho = 0; ortho < 2; ++ortho) { // also for squares and in parallel projection
        p.view.ortho_height = ortho != 0 ? 4.0 : 0.0;
        p.style.point_sizing = STP_POINTS_PIXELS;
        p.style.point_size = 6.0f;
        p.style.splat_shape = STP_SPLAT_SQUARE;
        CHECK(is_about(covered_from(&p, 5.0), POINTS * 36.0));
        p.style.splat_shape = STP_SPLAT_DISK;
        p.style.filter = STP_FILTER_EWA;
        CHECK(is_about(covered_from(&p, 5.0), POINTS * 28.27));
        p.style.filter = STP_FILTER_NONE;
    }
    made_picture_end(&p);
}

void test_sizes_of_points_leave_surfaces_alone(test_state* test)
{
    made_picture p;
    CHECK(made_picture_begin(&p, NULL, 1));
    made_picture_add(&p, 0.3, (stp_vec3d){0, 0, 0}, green);
    CHECK_EQUAL(STP_OK, made_picture_open(&p));
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    uint8_t before[sizeof(p.pixels)];
    memcpy(before, p.pixels, sizeof(before));
    p.style.point_sizing = STP_POINTS_PIXELS;
    p.style.point_size = 9.0f;
    p.quality.points_apart = true;
    CHECK_EQUAL(STP_OK, made_picture_draw(&p));
    CHECK(memcmp(before, p.pixels, sizeof(before)) == 0);
    made_picture_end(&p);
}

void test_gl_points_have_fixed_sizes(test_state* test)
{
    made_gl m;
    bool failed = false;
    if (!made_gl_begin_with(&m, add_points, NULL, NULL, &failed)) {
        CHECK(!failed);
        return;
    }
    static const stp_draw_style styles[] = {
        {.point_sizing = STP_POINTS_PIXELS, .point_size = 5.0f},
        {.point_sizing = STP_POINTS_PIXELS, .point_size = 1.0f},
        {.point_sizing = STP_POINTS_PIXELS, .point_size = 64.0f},
        {.point_sizing = STP_POINTS_UNITS, .point_size = 0.3f},
        {.point_sizing = STP_POINTS_UNITS, .point_size = 30.0f},
        {.point_sizing = STP_POINTS_PIXELS, .point_size = 5.0f, .splat_shape = STP_SPLAT_SQUARE},
    };
    for (size_t i = 0; i < sizeof(styles) / sizeof(styles[0]); ++i) {
        m.picture.style = styles[i];
        CHECK_EQUAL(STP_OK, made_picture_draw(&m.picture));
        CHECK_EQUAL(STP_OK, made_gl_draw(&m));
        CHECK(count_covered(m.pixels) >= POINTS);
        CHECK(made_count_different(m.picture.pixels, m.pixels, 8) <= 8);
    }
    made_gl_end(&m);
}

/// A red sheet that faces away, slightly in front of a green one that faces the eye.
static void add_sheets(made_picture* p, bool unknown)
{
    made_picture_add(p, 3.14159265358979, (stp_vec3d){0, 0, 0.02}, red);
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, green);
    for (uint32_t i = 0; i < 2; ++i) {
        p->scene.sets[i].unknown_signs = unknown;
    }
}

static void add_known(made_picture* p)
{
    add_sheets(p, false);
}

static void add_unknown(made_picture* p)
{
    add_sheets(p, true);
}

void test_unknown_signs_push_nothing_back(test_state* test)
{
    void (*const scenes[])(made_picture*) = {add_known, add_unknown};
    for (int unknown = 0; unknown < 2; ++unknown) {
        made_gl m;
        bool failed = false, gl = made_gl_begin_with(&m, scenes[unknown], NULL, NULL, &failed);
        made_picture* p = &m.picture;
        CHECK(!failed);
        if (!gl) {
            CHECK(made_picture_begin(p, NULL, 1));
            scenes[unknown](p);
            CHECK_EQUAL(STP_OK, made_picture_open(p));
        }
        p->quality.splats_only = true;
        CHECK_EQUAL(STP_OK, made_picture_draw(p));
        const uint8_t* middle = made_picture_pixel(p, 31, 31);
        CHECK_EQUAL(unknown ? 255 : 0, middle[0]); // only points known to face away are removed
        if (gl) {
            CHECK_EQUAL(STP_OK, made_gl_draw(&m));
            CHECK(made_count_different(p->pixels, m.pixels, 8) <= 8);
            made_gl_end(&m);
        } else {
            made_picture_end(p);
        }
    }
}
