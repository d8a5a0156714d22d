// SPDX-License-Identifier: MIT
// Backs of single-sided materials are not drawn: triangles and splats, on both backends.
#include "support_gl.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "select/pick_ray.h"
#include "select/sections.h"

#include <math.h>

static const uint8_t red[3] = {200, 40, 40};
static bool has_splats, is_mirrored, is_clustered, is_stretched;
static bool others_are_two_sided; ///< a second shading, without splats
static stp_coded_mesh coded[MADE_LIMIT];

static void add_front_only(made_picture* p)
{
    made_scene* s = &p->scene;
    made_picture_add(p, 0.0, (stp_vec3d){0, 0, 0}, has_splats ? red : NULL);
    s->materials[0].flags |= STP_SHADING_FRONT_ONLY;
    s->shadings[0].flags |= STP_SHADING_FRONT_ONLY;
    if (others_are_two_sided) {
        s->shadings[s->shading_count++] = (stp_shading){.roughness = 1};
    }
    if (is_mirrored) {
        s->edges[0].transform.m[0][0] = -1.0;
    }
    if (is_stretched) {
        s->edges[0].transform.m[1][1] = 0.9;
    }
    if (is_clustered) {
        const stp_store_mesh* m = &s->meshes[0];
        double step = stp_choose_grid_step(m->positions, m->indices, m->triangle_count);
        if (stp_clusters_encode(p->context, m, step, &coded[0]) == STP_OK) {
            s->coded_meshes = coded;
        }
    }
}

/// Draws from a side; -1 is behind. @return covered pixels, of OpenGL or the CPU; -1 on failure
static int count_covered(made_gl* m, bool by_gl, double side)
{
    made_picture* p = &m->picture;
    int count = 0;
    p->view.eye.z = 5.0 * side;
    if ((by_gl ? made_gl_draw(m) : made_picture_draw(p)) != STP_OK) {
        return -1;
    }
    const uint8_t* pixels = by_gl ? m->pixels : p->pixels;
    for (int i = 0; i < PICTURE_SIDE * PICTURE_SIDE; ++i) {
        count += pixels[4 * i + 3] != 0 ? 1 : 0;
    }
    return count;
}

static void check_sides(test_state* test, made_gl* m, bool by_gl)
{
    enum { SQUARE = PICTURE_SIDE * PICTURE_SIDE / 4, LESS = SQUARE * 9 / 10 };
    made_picture* p = &m->picture;
    CHECK(count_covered(m, by_gl, 1.0) > LESS);
    CHECK_EQUAL(0, count_covered(m, by_gl, -1.0));
    p->style.back_faces = true;
    CHECK(count_covered(m, by_gl, -1.0) > LESS);
    p->style.back_faces = false;
    p->view.ortho_height = 4.0;
    CHECK(count_covered(m, by_gl, 1.0) > LESS);
    CHECK_EQUAL(0, count_covered(m, by_gl, -1.0));
    p->view.ortho_height = 0.0;
    // a section anywhere in the view shows backs
    CHECK(stp_sections_add_plane(&p->view.sections, (stp_vec3d){0, 5, 0}, (stp_vec3d){0, 1, 0}));
    CHECK(count_covered(m, by_gl, -1.0) > LESS);
    p->view.sections.count = 0;
}

static void check_scene(test_state* test, bool by_gl)
{
    static made_gl m;
    bool failed;
    if (!by_gl) {
        m = (made_gl){.renderer = NULL};
        CHECK(made_picture_begin(&m.picture, NULL, 2));
        m.picture.quality.splat_size = 1;
        add_front_only(&m.picture);
        CHECK_EQUAL(STP_OK, made_picture_open(&m.picture));
    } else if (!made_gl_begin_with(&m, add_front_only, NULL, NULL, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    m.picture.quality.splats_only = has_splats;
    check_sides(test, &m, by_gl);
    for (int i = 0; i < MADE_LIMIT; ++i) {
        stp_coded_mesh_destroy(m.picture.context, &coded[i]);
    }
    made_gl_end(&m);
}

/// Disks of stretched items are not turned like their surface: none are dropped.
static void check_stretched(test_state* test, bool by_gl)
{
    static made_gl m;
    bool failed = true;
    has_splats = is_stretched = true;
    is_mirrored = is_clustered = others_are_two_sided = false;
    bool made = made_gl_begin_with(&m, add_front_only, NULL, NULL, &failed);
    is_stretched = false;
    m.picture.quality.splats_only = true;
    int front = made ? count_covered(&m, by_gl, 1.0) : 0;
    int back = made ? count_covered(&m, by_gl, -1.0) : 0;
    made_gl_end(&m);
    CHECK(made || !failed);
    if (!made) {
        SKIP("there is no OpenGL");
    }
    CHECK(front > 100 && back > front * 9 / 10);
}

static void check_all(test_state* test, bool by_gl)
{
    for (int i = 0; i < 8; ++i) {
        has_splats = (i & 1) != 0;
        is_mirrored = (i & 2) != 0;
        is_clustered = !has_splats && (i & 4) != 0;
        others_are_two_sided = has_splats && (i & 4) != 0;
        check_scene(test, by_gl);
    }
}

void test_backs_of_single_sided_materials_are_not_drawn(test_state* test)
{
    check_all(test, false);
}

void test_gl_backs_of_single_sided_materials_are_not_drawn(test_state* test)
{
    check_all(test, true);
}

// Rays pass what a picture does not show.
void test_picks_pass_backs_of_single_sided_materials(test_state* test)
{
    static made_picture p;
    for (int i = 0; i < 4; ++i) {
        has_splats = others_are_two_sided = false;
        is_mirrored = (i & 1) != 0;
        is_clustered = (i & 2) != 0;
        CHECK(made_picture_begin(&p, NULL, 1));
        add_front_only(&p);
        CHECK_EQUAL(STP_OK, made_picture_open(&p));
        for (int side = -1; side <= 1; side += 2) {
            stp_sections cut = {0};
            CHECK(stp_sections_add_plane(&cut, (stp_vec3d){0, 5, 0}, (stp_vec3d){0, 1, 0}));
            stp_pick_desc desc = {.ray = {.origin = {0.2, 0.1, 5.0 * side},
                                          .direction = {0, 0, -side},
                                          .farthest = HUGE_VAL}};
            stp_pick pick;
            CHECK_EQUAL(STP_OK, stp_pick_ray(p.context, p.store, &desc, &pick));
            CHECK_EQUAL(side > 0, pick.hit);
            desc.back_faces = true;
            CHECK_EQUAL(STP_OK, stp_pick_ray(p.context, p.store, &desc, &pick));
            CHECK(pick.hit);
            desc.back_faces = false;
            desc.sections = &cut;
            CHECK_EQUAL(STP_OK, stp_pick_ray(p.context, p.store, &desc, &pick));
            CHECK(pick.hit);
        }
        stp_coded_mesh_destroy(p.context, &coded[0]);
        made_picture_end(&p);
    }
}

void test_backs_of_stretched_splats_are_drawn(test_state* test)
{
    check_stretched(test, false);
    check_stretched(test, true);
}
