// SPDX-License-Identifier: MIT
// Culling of splat groups in OpenGL: draws fewer splats, with the same picture as the CPU.
#include "support_gl.h"
#include "tests.h"

#include "base/splats/coverage.h"
#include "base/splats/octahedral.h"
#include "draw/gl/gl_renderer.h"
#include "lod/set_columns.h"
#include "lod/spt/spt_set.h"

#include <string.h>

enum { SAMPLES = 40000, PIXELS = PICTURE_SIDE * PICTURE_SIDE, VIEWS = 6 };

// A ball of radius 1, seen from outside or, with `faces_in`, from inside. Samples lie along a
// spiral.
static void make_ball(made_picture* p, bool faces_in, stp_tree_error error)
{
    static uint16_t positions[3 * SAMPLES];
    static int8_t normals[2 * SAMPLES];
    static uint8_t materials[SAMPLES], colors[3 * SAMPLES], coverages[SAMPLES];
    for (uint32_t i = 0; i < SAMPLES; ++i) {
        double y = 1.0 - 2.0 * ((double)i + 0.5) / SAMPLES, around = 2.399963229728653 * i;
        double across = sqrt(1.0 - y * y);
        stp_vec3 n = {(float)(across * cos(around)), (float)y, (float)(across * sin(around))};
        float side = faces_in ? -1.0f : 1.0f;
        positions[3 * i] = (uint16_t)(32768.0f + 32000.0f * n.x);
        positions[3 * i + 1] = (uint16_t)(32768.0f + 32000.0f * n.y);
        positions[3 * i + 2] = (uint16_t)(32768.0f + 32000.0f * n.z);
        stp_octahedral_encode((stp_vec3){side * n.x, side * n.y, side * n.z}, normals + 2 * i);
        colors[3 * i] = (uint8_t)(128.0f + 120.0f * n.x);
        colors[3 * i + 1] = (uint8_t)(128.0f + 120.0f * n.y);
        colors[3 * i + 2] = (uint8_t)(128.0f + 120.0f * n.z);
        coverages[i] = STP_COVERAGE_WHOLE;
    }
    stp_splats samples = {.count = SAMPLES,
                          .origin = {-1.0f, -1.0f, -1.0f},
                          .step = 1.0f / 32768.0f,
                          .positions = positions,
                          .normals = normals,
                          .materials = materials,
                          .octave_count = 1,
                          .octave_ends = {SAMPLES},
                          .colors = colors,
                          .coverages = coverages,
                          .table = {.size = 1, .count = {SAMPLES}, .radius = {0.02f}},
                          .candidate_radius = 0.001f};
    const stp_spt_desc desc = {.tree = {error, 255}};
    made_scene* s = &p->scene;
    if (stp_spt_make(p->context, &samples, &desc, &s->sets[0]) != STP_OK) {
        return;
    }
    s->set_count = s->mesh_count = s->part_count = s->node_count = s->edge_count = 1;
    s->meshes[0] = made_square(0);
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->nodes[0] =
        (stp_store_node){.part_count = 1, .triangle_count = 2, .bounds = {{-1, -1, -1}, {1, 1, 1}}};
    s->edges[0] = (stp_store_edge){0, stp_affine_identity()};
    s->method =
        (stp_store_method){.name = "spt", .id = STP_METHOD_SPT, .columns = s->sets[0].columns};
}

static void add_ball(made_picture* p)
{
    make_ball(p, false, STP_TREE_GEOMETRIC);
}

static void add_room(made_picture* p)
{
    make_ball(p, true, STP_TREE_GEOMETRIC);
}

static void add_split_ball(made_picture* p)
{
    make_ball(p, false, STP_TREE_SPLIT);
}

typedef struct fixture {
    made_gl gl;
    stp_draw_item item; ///< all items
    stp_draw_run* runs; ///< NULL, or the item's
    uint8_t pixels[4 * PIXELS];
} fixture;

/// @return false if there is no OpenGL, or on failure, with *failed true
static bool set_up(fixture* f, void (*add)(made_picture* p), bool* failed)
{
    if (!made_gl_begin_with(&f->gl, add, NULL, NULL, failed)) {
        return false;
    }
    uint32_t count = f->gl.picture.scene.sets[0].count;
    f->item = (stp_draw_item){.kind = STP_DRAW_SPLATS,
                              .prefix = count,
                              .full_prefix = count,
                              .radius = 0.02f,
                              .level_per_depth = 0.004f,
                              .one_sided = true,
                              .transform = stp_affine_identity()};
    f->runs = NULL;
    *failed = count == 0;
    return count > 0;
}

static void tear_down(fixture* f)
{
    stp_splats* set = &f->gl.picture.scene.sets[0];
    f->gl.picture.scene.set_count = 0; // freed here, because it has more columns
    stp_splats_destroy(f->gl.picture.context, set);
    made_gl_end(&f->gl);
}

static stp_result draw_by(fixture* f, stp_renderer* renderer)
{
    made_picture* p = &f->gl.picture;
    stp_draw_list list = {.items = &f->item,
                          .count = 1,
                          .runs = f->runs,
                          .run_count = f->item.run_count,
                          .splat_count = f->item.prefix,
                          .splat_size = 1.0f};
    stp_image image = {PICTURE_SIDE, PICTURE_SIDE, f->pixels};
    return stp_renderer_draw(renderer, &p->view, &list, &p->style, &image, &p->stats);
}

/// Number of splats that the commands of the last picture draw for its last eye.
static uint64_t count_splats(const fixture* f)
{
    const stp_gl_commands* c =
        &((const stp_gl_renderer*)f->gl.renderer)->frame.commands[GL_COMMANDS_SPLATS];
    uint64_t count = 0;
    for (size_t i = 0; i < c->count; ++i) {
        count += c->commands[i].count;
    }
    return count;
}

/// From outside at several distances, or from inside; the last views have two eyes, samples, or
/// parallel projection.
static void choose_view(fixture* f, int i, bool within)
{
    stp_view* view = &f->gl.picture.view;
    double around = 0.8 * i, away = within ? 0.3 : 1.6 + 0.3 * i;
    view->eye = (stp_vec3d){away * cos(around), 0.2 * i - 0.6, away * sin(around)};
    view->target = within ? (stp_vec3d){sin(around), 0.1, -cos(around)} : (stp_vec3d){0.2, 0.3, 0};
    view->fov_degrees = 40.0;
    view->near_distance = 0.01;
    view->eye_distance = i == VIEWS - 1 || i == VIEWS - 2 ? 0.1 : 0.0;
    view->ortho_height = i == VIEWS - 3 && !within ? 1.5 : 0.0;
    f->gl.picture.style.supersample = i == VIEWS - 4 || i == VIEWS - 1 ? 2 : 1;
}

/// OpenGL draws fewer splats, with few commands.
static void check_commands(test_state* test, const fixture* f)
{
    const stp_gl_renderer* r = (const stp_gl_renderer*)f->gl.renderer;
    size_t commands = r->frame.commands[GL_COMMANDS_SPLATS].count;
    CHECK(10 * count_splats(f) < 9 * (uint64_t)f->item.prefix);
    CHECK(commands > 1 && commands < f->item.prefix / STP_GROUP_SPLATS / 4);
}

/// The CPU draws the same picture with and without back faces. Adds the fragments of both.
static void compare_sides(test_state* test, fixture* f, const uint8_t* by_gl, uint64_t fragments[2])
{
    static uint8_t one_sided[4 * PIXELS];
    stp_renderer* cpu = f->gl.picture.renderer;
    CHECK_EQUAL(STP_OK, draw_by(f, cpu));
    fragments[0] += f->gl.picture.stats.fragments;
    memcpy(one_sided, f->pixels, sizeof(one_sided));
    CHECK(f->gl.picture.stats.covered_pixels > PIXELS / 2);
    CHECK(made_count_different(one_sided, by_gl, 8) < PIXELS / 200);
    f->item.one_sided = false;
    CHECK_EQUAL(STP_OK, draw_by(f, cpu));
    f->item.one_sided = true;
    CHECK_EQUAL(0, made_count_different(one_sided, f->pixels, 0));
    fragments[1] += f->gl.picture.stats.fragments;
}

/// Draws views with OpenGL and on the CPU, with and without group culling.
static void compare_views(test_state* test, fixture* f, bool within)
{
    static uint8_t whole[4 * PIXELS], by_gl[4 * PIXELS];
    uint64_t fragments[2] = {0};
    stp_gl_renderer* r = (stp_gl_renderer*)f->gl.renderer;
    for (int i = 0; i < VIEWS; ++i) {
        stp_draw_gl_set_splats(f->gl.renderer,
                               i % 2 == 0 ? STP_GL_SPLATS_POINTS : STP_GL_SPLATS_COMPUTE);
        choose_view(f, i, within);
        r->omits.groups = true;
        CHECK_EQUAL(STP_OK, draw_by(f, f->gl.renderer));
        CHECK_EQUAL(f->item.prefix, count_splats(f));
        memcpy(whole, f->pixels, sizeof(whole));
        r->omits.groups = false;
        CHECK_EQUAL(STP_OK, draw_by(f, f->gl.renderer));
        memcpy(by_gl, f->pixels, sizeof(by_gl));
        check_commands(test, f);
        CHECK_EQUAL(0, made_count_different(whole, by_gl, 0));
        compare_sides(test, f, by_gl, fragments);
    }
    CHECK(within || 20 * fragments[0] <
                        19 * fragments[1]); // the fragments of each picture depend on the threads
}

void test_gl_culled_groups_change_no_pixel(test_state* test)
{
    static fixture f;
    void (*const scenes[])(made_picture * p) = {add_ball, add_room, add_split_ball};
    for (int i = 0; i < 3; ++i) {
        bool failed;
        if (!set_up(&f, scenes[i], &failed)) {
            tear_down(&f);
            CHECK(!failed);
            SKIP("there is no OpenGL");
        }
        compare_views(test, &f, i == 1);
        tear_down(&f);
    }
}

// Ghosts and sections show back faces, and so do views that request all sides.
void test_gl_back_facing_groups_stay_where_they_show(test_state* test)
{
    static fixture f;
    bool failed;
    if (!set_up(&f, add_ball, &failed)) {
        tear_down(&f);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    choose_view(&f, 2, false);
    f.gl.picture.view.fov_degrees = 90.0;
    CHECK_EQUAL(STP_OK, draw_by(&f, f.gl.renderer));
    uint64_t drawn = count_splats(&f);
    CHECK(drawn < f.item.prefix);
    const stp_draw_item item = f.item;
    for (int i = 0; i < 3; ++i) {
        f.item = item;
        f.item.ghost = i == 0;
        f.item.sections = i == 1 ? 1 : 0;
        f.item.one_sided = i != 2;
        CHECK_EQUAL(STP_OK, draw_by(&f, f.gl.renderer));
        CHECK_EQUAL(f.item.prefix, count_splats(&f)); // the whole ball is in the picture
    }
    // outside the picture, only the group with the largest splats is drawn, because it surrounds
    // the eye
    f.gl.picture.view.target = stp_scaled(f.gl.picture.view.eye, 2.0);
    CHECK_EQUAL(STP_OK, draw_by(&f, f.gl.renderer));
    CHECK(count_splats(&f) <= STP_GROUP_SPLATS);
    tear_down(&f);
}

// Runs end between groups; each command keeps to the depths of its run.
void test_gl_groups_keep_to_runs(test_state* test)
{
    static fixture f;
    static uint8_t whole[4 * PIXELS];
    bool failed;
    if (!set_up(&f, add_ball, &failed)) {
        tear_down(&f);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    stp_gl_renderer* r = (stp_gl_renderer*)f.gl.renderer;
    stp_draw_run runs[] = {
        {.end = 64 * 20}, {64 * 20, 64 * 301, 1.2f, 2.0f}, {64 * 301, f.item.prefix, 0.0f, 1.5f}};
    f.runs = runs;
    f.item.run_count = 3;
    choose_view(&f, 0, false);
    for (int i = 0; i < 2; ++i) {
        r->omits.groups = i == 0;
        CHECK_EQUAL(STP_OK, draw_by(&f, f.gl.renderer));
        if (i == 0) {
            CHECK(count_splats(&f) == f.item.prefix);
            memcpy(whole, f.pixels, sizeof(whole));
        }
    }
    CHECK_EQUAL(0, made_count_different(whole, f.pixels, 0));
    const stp_gl_commands* c = &r->frame.commands[GL_COMMANDS_SPLATS];
    CHECK(c->count > 3 && count_splats(&f) < f.item.prefix);
    for (size_t i = 0; i < c->count; ++i) {
        const record_block* record = &r->frame.records[c->commands[i].base];
        uint32_t end = record->first + c->commands[i].count;
        int run = record->first < runs[0].end ? 0 : record->first < runs[1].end ? 1 : 2;
        CHECK(end <= runs[run].end);
        CHECK(record->farthest == (run == 0 ? HUGE_VALF : runs[run].farthest));
    }
    tear_down(&f);
}
