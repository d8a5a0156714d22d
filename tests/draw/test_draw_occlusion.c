// SPDX-License-Identifier: MIT
// Pictures drawn in two passes with occlusion culling equal those drawn without.
#include "support_store.h"
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "draw/draw.h"
#include "select/pyramid_helpers.h"

#include <string.h>

enum { WIDTH = 200, HEIGHT = 120, BEHIND = 6, PIXELS = WIDTH * HEIGHT };

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

static stp_affine placed(double size, double turn, stp_vec3d at)
{
    double c = size * cos(turn), s = size * sin(turn);
    return (stp_affine){{{c, 0, s, at.x}, {0, size, 0, at.y}, {-s, 0, c, at.z}}};
}

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    uint8_t pixels[4 * PIXELS], expected[4 * PIXELS];
    float nearness[PIXELS];
} fixture;

// A wall of triangles; behind, in front of and beside it, squares with splats over triangles.
static bool set_up(fixture* f, uint64_t round)
{
    static const uint8_t colors[2][3] = {{200, 60, 20}, {30, 90, 220}};
    made_scene* s = &f->scene;
    f->context = test_context(NULL, 2, NULL);
    if (f->context == NULL) {
        return false;
    }
    *s = (made_scene){.node_count = 4,
                      .part_count = 3,
                      .material_count = 1,
                      .shading_count = 1,
                      .mesh_count = 1,
                      .set_count = 2,
                      .edge_count = 1 + BEHIND};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[0] = made_square_set(f->context, 5, colors[0]);
    s->sets[1] = made_square_set(f->context, 6, colors[1]);
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    for (uint32_t i = 0; i < 3; ++i) {
        s->parts[i] = (stp_store_part){STP_STORE_PART_MESH, 0};
        s->nodes[i] = (stp_store_node){.first_part = i,
                                       .part_count = 1,
                                       .set = i == 0 ? STP_STORE_NONE : i - 1,
                                       .triangle_count = 2,
                                       .bounds = flat};
    }
    stp_boxd all = stp_boxd_empty();
    for (uint32_t i = 0; i < s->edge_count; ++i) {
        stp_vec3d at = {uniform(round, 10 + 5 * i, -2, 2), uniform(round, 11 + 5 * i, -1.5, 1.5),
                        uniform(round, 12 + 5 * i, -9.0, 1.5)};
        stp_affine transform = i == 0 ? placed(2.2, 0.3, (stp_vec3d){0.3, 0, 0})
                                      : placed(uniform(round, 13 + 5 * i, 0.2, 0.9),
                                               uniform(round, 14 + 5 * i, 0, 6.3), at);
        s->edges[i] = (stp_store_edge){i == 0 ? 0 : 1 + i % 2, transform};
        stp_boxd box = stp_affine_box(&transform, flat);
        stp_boxd_add(&all, box.min);
        stp_boxd_add(&all, box.max);
    }
    s->nodes[3] = (stp_store_node){.edge_count = s->edge_count,
                                   .set = STP_STORE_NONE,
                                   .triangle_count = 2 * s->edge_count,
                                   .bounds = all};
    f->store = made_open(f->context, s);
    return f->store != NULL && stp_draw_cpu_create(f->context, f->store, &f->renderer) == STP_OK;
}

static void tear_down(fixture* f)
{
    made_free_set(f->context, &f->scene.sets[0]);
    made_free_set(f->context, &f->scene.sets[1]);
    stp_renderer_destroy(f->renderer);
    stp_draw_list_destroy(f->context, &f->list);
    stp_store_close(f->store);
    stp_context_destroy(f->context);
}

static stp_result draw(fixture* f, const stp_view* view)
{
    stp_image image = {WIDTH, HEIGHT, f->pixels};
    stp_draw_style style = {.splat_scale = 1.0f};
    stp_draw_stats stats;
    return stp_renderer_draw(f->renderer, view, &f->list, &style, &image, &stats);
}

static stp_view view_at(uint64_t round, double step)
{
    return (stp_view){.eye = {uniform(round, 0, -1.5, 1.5) + step, uniform(round, 1, -1, 1),
                              uniform(round, 2, 2.5, 6.0) - step},
                      .target = {0.4 * step, 0, -1},
                      .up = {0, 1, 0},
                      .fov_degrees = 60,
                      .near_distance = 0.01,
                      .width = WIDTH,
                      .height = HEIGHT};
}

void test_draw_occlusion_changes_no_pixel(test_state* test)
{
    static fixture f;
    int hidden = 0, repaired = 0;
    for (uint64_t round = 0; round < 40; ++round) {
        f = (fixture){0};
        CHECK(set_up(&f, round));
        stp_depth_pyramid pyramid = {0};
        stp_quality quality = {.splat_size = (float)(1 + round % 4)};
        stp_view before = view_at(round, round % 3 == 0 ? 0.0 : 2.0), view = view_at(round, 0.0);
        // what an earlier frame hid
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &before, &quality, &f.list));
        CHECK_EQUAL(STP_OK, draw(&f, &before));
        CHECK_EQUAL(STP_OK,
                    make_pyramid(f.context, &before, stp_renderer_depth(f.renderer), &pyramid));
        // the expected picture
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
        CHECK_EQUAL(STP_OK, draw(&f, &view));
        memcpy(f.expected, f.pixels, sizeof(f.pixels));
        memcpy(f.nearness, stp_renderer_depth(f.renderer), sizeof(f.nearness));
        size_t whole = f.list.count;
        // both passes
        quality.occlusion = &pyramid;
        CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
        CHECK_EQUAL(f.list.first_pass_count, f.list.count);
        CHECK(f.list.count + f.list.hidden_count == 0 || f.list.count < whole + 1);
        size_t first = f.list.count;
        CHECK_EQUAL(STP_OK, draw(&f, &view));
        CHECK_EQUAL(STP_OK,
                    make_pyramid(f.context, &view, stp_renderer_depth(f.renderer), &pyramid));
        CHECK_EQUAL(STP_OK, stp_select_rejected(f.context, f.store, &view, &quality, &f.list));
        CHECK_EQUAL(first, f.list.first_pass_count);
        CHECK_EQUAL(STP_OK, draw(&f, &view));
        CHECK_EQUAL(0, memcmp(f.nearness, stp_renderer_depth(f.renderer), sizeof(f.nearness)));
        CHECK_EQUAL(0, memcmp(f.expected, f.pixels, sizeof(f.pixels)));
        hidden += (int)f.list.hidden_count;
        repaired += f.list.count > first;
        stp_depth_pyramid_destroy(f.context, &pyramid);
        tear_down(&f);
    }
    CHECK(hidden > 40 && repaired > 3); // otherwise the test proves nothing
}

void test_draw_selected_is_the_whole_picture(test_state* test)
{
    static fixture f;
    int hidden = 0, repaired = 0;
    for (uint64_t round = 0; round < 30; ++round) {
        f = (fixture){0};
        CHECK(set_up(&f, round));
        stp_quality quality = {.splat_size = (float)(1 + round % 4)};
        stp_draw_style style = {.splat_scale = 1.0f};
        stp_image image = {WIDTH, HEIGHT, f.pixels};
        stp_draw_stats stats;
        for (int frame = 0; frame < 4; ++frame) { // the eye moves, then rests
            stp_view view = view_at(round, frame == 0 ? 2.0 : frame == 1 ? 0.3 : 0.0);
            CHECK_EQUAL(STP_OK, stp_select(f.context, f.store, &view, &quality, &f.list));
            CHECK_EQUAL(STP_OK, draw(&f, &view));
            memcpy(f.expected, f.pixels, sizeof(f.pixels));
            memcpy(f.nearness, stp_renderer_depth(f.renderer), sizeof(f.nearness));
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style,
                                                           &f.list, &image, &stats));
            CHECK_EQUAL(0, memcmp(f.nearness, stp_renderer_depth(f.renderer), sizeof(f.nearness)));
            CHECK_EQUAL(0, memcmp(f.expected, f.pixels, sizeof(f.pixels)));
            CHECK_EQUAL(f.list.count, stats.draw_calls);
            hidden += (int)f.list.hidden_count;
            repaired += f.list.count > f.list.first_pass_count;
        }
        tear_down(&f);
    }
    CHECK(hidden > 40 && repaired > 3); // otherwise the test proves nothing
}

// A list beyond the limit is not drawn, at any resolution; the next frame is as if it had not been.
void test_draw_selected_refuses_long_lists(test_state* test)
{
    static fixture f;
    f = (fixture){0};
    CHECK(set_up(&f, 3));
    stp_quality quality = {.splat_size = 2.0f};
    stp_draw_style style = {.splat_scale = 1.0f};
    stp_image image = {WIDTH, HEIGHT, f.pixels};
    stp_draw_stats stats, again;
    stp_view view = view_at(3, 0.0);
    for (int lower = 0; lower < 2; ++lower) {
        style.resolution = lower != 0 ? 0.5f : 0.0f;
        quality.limit = (stp_work_limit){0};
        CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style, &f.list,
                                                       &image, &stats));
        CHECK(!stats.exceeds);
        uint64_t all = stats.listed_splats + stats.listed_triangles + stats.draw_calls;
        memcpy(f.expected, f.pixels, sizeof(f.pixels));
        quality.limit = (stp_work_limit){1.0, 1.0, 1.0, 1.0};
        memset(f.pixels, 7, sizeof(f.pixels));
        CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style, &f.list,
                                                       &image, &again));
        CHECK(again.exceeds && again.fragments == 0 && again.splats == 0);
        CHECK(again.listed_splats + again.listed_triangles > 0 && again.draw_calls > 0);
        for (size_t i = 0; i < sizeof(f.pixels); ++i) {
            CHECK(f.pixels[i] == 7);
        }
        quality.limit.most = 2.0 * (double)all;
        CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style, &f.list,
                                                       &image, &again));
        CHECK(!again.exceeds);
        CHECK_EQUAL(0, memcmp(f.expected, f.pixels, sizeof(f.pixels)));
    }
    tear_down(&f);
}

// A list that becomes too long only with what the second pass adds is not drawn, either. The next
// frame is as if it had not been.
void test_draw_selected_refuses_long_second_passes(test_state* test)
{
    static fixture f;
    int refused = 0;
    for (uint64_t round = 0; round < 60; ++round) {
        f = (fixture){0};
        CHECK(set_up(&f, round));
        stp_draw_style style = {.splat_scale = 1.0f};
        stp_image image = {WIDTH, HEIGHT, f.pixels};
        stp_draw_stats stats;
        stp_quality quality = {.splat_size = (float)(1 + round % 4)};
        stp_view before = view_at(round, 0.3), view = view_at(round, 2.0);
        stp_view* const turns[] = {&before, &view};
        for (int turn = 0; turn < 2; ++turn) {
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, turns[turn], &quality,
                                                           &style, &f.list, &image, &stats));
        }
        memcpy(f.expected, f.pixels, sizeof(f.pixels));
        const size_t both = f.list.count, first = f.list.first_pass_count;
        for (size_t most = first; most <= both && both > first; most += both - first) {
            quality.limit = (stp_work_limit){0};
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &before, &quality, &style,
                                                           &f.list, &image, &stats));
            quality.limit = (stp_work_limit){.item = 1.0, .most = (double)most};
            memset(f.pixels, 7, sizeof(f.pixels));
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style,
                                                           &f.list, &image, &stats));
            CHECK_EQUAL(most < both, stats.exceeds);
            CHECK_EQUAL(both, stats.draw_calls);
            for (size_t i = 0; i < sizeof(f.pixels) && stats.exceeds; ++i) {
                CHECK(f.pixels[i] == 7);
            }
            refused += stats.exceeds;
            quality.limit = (stp_work_limit){0};
            CHECK_EQUAL(STP_OK, stp_renderer_draw_selected(f.renderer, &view, &quality, &style,
                                                           &f.list, &image, &stats));
            CHECK_EQUAL(0, memcmp(f.expected, f.pixels, sizeof(f.pixels)));
        }
        tear_down(&f);
    }
    CHECK(refused > 3); // otherwise the test proves nothing
}
