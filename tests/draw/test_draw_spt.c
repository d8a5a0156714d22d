// SPDX-License-Identifier: MIT
// Sets of Sequential Point Trees in a view: selected splats, and pictures of a closed surface
// without holes.
#include "support_store.h"
#include "tests.h"

#include "base/splats/splat_codes.h"
#include "draw/draw.h"
#include "lod/set_columns.h"
#include "lod/spt/spt_set.h"

#include <string.h>

enum { SIDE = 128, LOG_SIDE = 6 };

typedef struct fixture {
    stp_context* context;
    made_scene scene;
    stp_splats samples, set;
    stp_store* store;
    stp_renderer* renderer;
    stp_draw_list list;
    stp_view view;
    stp_quality quality;
    uint8_t pixels[SIDE * SIDE * 4];
} fixture;

// The square from -1 to 1 with 4,096 samples and two triangles that count as a million.
static bool set_up(fixture* f, stp_tree_error error)
{
    static const uint8_t red[3] = {255, 0, 0};
    *f = (fixture){.context = test_context(NULL, 2, NULL)};
    stp_spt_desc desc = {.tree = {error, 255}};
    f->samples = made_square_set(f->context, LOG_SIDE, red);
    if (stp_spt_make(f->context, &f->samples, &desc, &f->set) != STP_OK) {
        return false;
    }
    stp_store_mesh square = made_square(0);
    made_one_node(&f->scene, &square, &f->set);
    f->store = made_open(f->context, &f->scene);
    f->view = (stp_view){
        .eye = {0, 0, 5}, .up = {0, 1, 0}, .fov_degrees = 60, .width = SIDE, .height = SIDE};
    f->quality = (stp_quality){.splat_size = 1.0f, .early_switch = 1};
    return f->store != NULL && stp_draw_cpu_create(f->context, f->store, &f->renderer) == STP_OK;
}

static void tear_down(fixture* f)
{
    stp_renderer_destroy(f->renderer);
    stp_draw_list_destroy(f->context, &f->list);
    stp_store_close(f->store);
    made_free_set(f->context, &f->samples);
    stp_splats_destroy(f->context, &f->set);
    stp_context_destroy(f->context);
}

static stp_result draw(fixture* f)
{
    stp_image image = {SIDE, SIDE, f->pixels};
    stp_draw_style style = {0};
    stp_draw_stats stats;
    stp_result result = stp_select(f->context, f->store, &f->view, &f->quality, &f->list);
    return result == STP_OK
               ? stp_renderer_draw(f->renderer, &f->view, &f->list, &style, &image, &stats)
               : result;
}

// Whether all pixels of the square are covered, except those at its edge.
static bool is_whole(const fixture* f, double distance)
{
    double half =
        0.5 * SIDE / (distance * 0.57735026918962576); // half the square's side, in pixels
    int begin = (int)(0.5 * SIDE - half) + 2, end = (int)(0.5 * SIDE + half) - 2;
    for (int y = begin; y < end; ++y) {
        for (int x = begin; x < end; ++x) {
            if (f->pixels[4 * (y * SIDE + x) + 3] == 0) {
                return false;
            }
        }
    }
    return begin < end;
}

static void check_holes(test_state* test, stp_tree_error error)
{
    fixture f;
    CHECK(set_up(&f, error));
    int drawn = 0;
    for (int i = 0; i < 24; ++i) {
        double distance = 6.0 * pow(1.07, i);
        f.view.eye.z = distance;
        f.view.target.z = 0.0;
        f.quality.splat_size = (float)(1 + i % 6);
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(is_whole(&f, distance));
        const stp_draw_item* item = &f.list.items[0];
        if (f.list.count == 1 && item->kind == STP_DRAW_SPLATS) {
            drawn += 1;
            // the prefix contains all that a level needs
            double level = fmax((double)item->level_per_depth * distance, (double)item->level_min);
            CHECK(item->level_per_depth > 0.0f || item->level_min > 0.0f);
            for (uint32_t k = item->prefix; k < f.set.count; ++k) {
                CHECK((double)stp_range_level(f.set.ranges[k] >> 16) <= level * (1.0 + 1e-6));
            }
        }
    }
    CHECK(drawn > 12);
    tear_down(&f);
}

void test_spt_draws_without_holes(test_state* test)
{
    check_holes(test, STP_TREE_GEOMETRIC);
}

void test_spt_draws_split_errors_without_holes(test_state* test)
{
    check_holes(test, STP_TREE_SPLIT);
}

// Near the eye the samples are too coarse: triangles are drawn. Farther away, fewer and fewer
// splats are drawn.
void test_spt_needs_fewer_splats_from_afar(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, STP_TREE_GEOMETRIC));
    f.view.eye.z = 1.5;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(f.list.count == 1 && f.list.items[0].kind == STP_DRAW_MESH);
    uint64_t before = UINT64_MAX;
    for (double distance = 12.0; distance < 2000.0; distance *= 1.5) {
        f.view.eye.z = distance;
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(f.list.count == 1 && f.list.items[0].kind == STP_DRAW_SPLATS);
        CHECK(f.list.splat_count <= before);
        before = f.list.splat_count;
    }
    CHECK(before < 300);
    // with a limit; they still cover
    f.view.eye.z = 12.0;
    for (uint64_t count = 20; count < 4000; count *= 3) {
        f.quality.splat_count = count;
        CHECK_EQUAL(STP_OK, draw(&f));
        CHECK(f.list.splat_count <= count && is_whole(&f, 12.0));
    }
    // parallel projection has one level for all
    f.quality.splat_count = 0;
    f.view.ortho_height = 4.0;
    f.quality.splat_size = 8.0f;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(f.list.count == 1 && f.list.items[0].kind == STP_DRAW_SPLATS);
    CHECK(f.pixels[4 * (SIDE * SIDE / 2 + SIDE / 2) + 3] != 0);
    tear_down(&f);
}

// If a file lacks the method, its first one is drawn.
void test_spt_is_drawn_if_the_requested_method_is_missing(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, STP_TREE_GEOMETRIC));
    f.view.eye.z = 20.0;
    CHECK_EQUAL(STP_OK, draw(&f));
    uint64_t count = f.list.splat_count;
    f.quality.method = STP_METHOD_STOCHASTIC;
    CHECK_EQUAL(STP_OK, draw(&f));
    CHECK(count > 0 && count == f.list.splat_count);
    tear_down(&f);
}
