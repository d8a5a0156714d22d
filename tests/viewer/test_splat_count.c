// SPDX-License-Identifier: MIT
// The available number of splats, and the effect of keys on it.
#include "tests.h"

#include "base/math/math.h"
#include "draw/support_store.h"
#include "program/viewer/model/splat_count.h"
#include "select/select.h"
#include "select/support_built.h"
#include "store/support_progressive.h"

static const uint8_t grey[3] = {128, 128, 128};
enum { SPLATS_OF_ROOT = 1024, SPLATS_BELOW = 64 };

/// The number of splats that a view draws if all are requested.
static uint64_t count_drawn(stp_context* context, stp_store* store, const stp_view* view)
{
    stp_draw_list list = {0};
    stp_quality quality = {.splat_count = SPLAT_COUNT_MAX};
    bool drawn = stp_select(context, store, view, &quality, &list) == STP_OK;
    uint64_t count = drawn ? list.splat_count : UINT64_MAX;
    stp_draw_list_destroy(context, &list);
    return count;
}

/// A root with a square: once without a set, twice with one.
static void make_scene(stp_context* context, made_scene* s)
{
    stp_boxd flat = {{-1, -1, 0}, {1, 1, 0}};
    *s = (made_scene){.node_count = 3,
                      .edge_count = 3,
                      .part_count = 2,
                      .material_count = 1,
                      .shading_count = 1,
                      .mesh_count = 1,
                      .set_count = 2};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[0] = made_square_set(context, 5, grey);
    s->sets[1] = made_square_set(context, 3, grey);
    s->parts[0] = s->parts[1] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->nodes[0] = (stp_store_node){
        .part_count = 1, .set = STP_STORE_NONE, .triangle_count = 2, .bounds = flat};
    s->nodes[1] = s->nodes[0];
    s->nodes[1].first_part = 1;
    s->nodes[1].set = 1;
    for (uint32_t i = 0; i < 3; ++i) {
        s->edges[i] = (stp_store_edge){i > 0, stp_affine_identity()};
        s->edges[i].transform.m[2][3] = 0.5 * i;
    }
    s->nodes[2] = (stp_store_node){
        .edge_count = 3, .set = 0, .triangle_count = 6, .bounds = {{-1, -1, 0}, {1, 1, 1}}};
}

void test_viewer_splat_count_is_what_a_view_draws_at_most(test_state* test)
{
    const struct {
        bool root_has_set, below_moves;
        uint32_t count;
    } cases[] = {{true, false, SPLATS_OF_ROOT},
                 {true, true, SPLATS_OF_ROOT + 2 * SPLATS_BELOW},
                 {false, false, 2 * SPLATS_BELOW},
                 {false, true, 2 * SPLATS_BELOW}};
    stp_view view = {
        .eye = {0, 0, 50}, .up = {0, 1, 0}, .fov_degrees = 90, .width = 200, .height = 200};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_context* context = test_context(NULL, 1, NULL);
        made_scene scene;
        make_scene(context, &scene);
        scene.nodes[2].set = cases[i].root_has_set ? 0 : STP_STORE_NONE;
        scene.nodes[1].flags = cases[i].below_moves;
        stp_store* store = made_open(context, &scene);
        CHECK(store != NULL);
        CHECK_EQUAL(cases[i].count, splat_count_of_scene(store, 0));
        CHECK_EQUAL(cases[i].count, count_drawn(context, store, &view));
        CHECK_EQUAL(0, splat_count_of_scene(store, 1)); // there is no second method
        stp_store_close(store);
        made_free_set(context, &scene.sets[0]);
        made_free_set(context, &scene.sets[1]);
        stp_context_destroy(context);
    }
}

/// The square with one progressive set, placed twice.
static stp_store* open_progressive(stp_context* context, stp_arena* arena, uint32_t base,
                                   uint32_t splits)
{
    static made_scene scene;
    make_scene(context, &scene);
    made_free_set(context, &scene.sets[0]);
    made_free_set(context, &scene.sets[1]);
    progressive_desc desc = {.seed = 5, .base = base, .splits = splits};
    if (!progressive_sample_make(arena, &desc, &scene.sets[0])) {
        return NULL;
    }
    progressive_sample_octaves(&scene.sets[0], 16);
    scene.set_count = 1;
    scene.nodes[1].set = 0;
    scene.nodes[2].set = STP_STORE_NONE;
    scene.method = (stp_store_method){.name = "psp",
                                      .id = STP_METHOD_PSP,
                                      .columns = STP_SPLATS_SHAPES | STP_SPLATS_RANGES |
                                                 STP_SPLATS_FLAT_COLORS};
    return made_open(context, &scene);
}

void test_viewer_splat_count_of_merged_splats_with_many_roots(test_state* test)
{
    const struct {
        uint32_t base, splits;
    } cases[] = {{1, 0}, {1, 40}, {2, 1}, {50, 0}, {7, 60}, {30, 3}};
    stp_view view = {
        .eye = {0, 0, 50}, .up = {0, 1, 0}, .fov_degrees = 90, .width = 200, .height = 200};
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); ++i) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_arena arena = stp_arena_create(context, 1 << 16);
        stp_store* store = open_progressive(context, &arena, cases[i].base, cases[i].splits);
        CHECK(store != NULL);
        uint32_t count = splat_count_of_scene(store, 0);
        CHECK_EQUAL(2 * (cases[i].base + cases[i].splits), count);
        CHECK_EQUAL(count, count_drawn(context, store, &view));
        stp_store_close(store);
        stp_arena_destroy(&arena);
        stp_context_destroy(context);
    }
}

void test_viewer_splat_count_of_built_scenes(test_state* test)
{
    uint32_t with_splats = 0;
    for (uint64_t seed = 1; seed <= 12; ++seed) {
        stp_context* context = test_context(NULL, 1, NULL);
        stp_store* store = built_open(context, seed, true);
        CHECK(store != NULL);
        const stp_store_directory* d = stp_store_get_directory(store);
        if (d->root != STP_STORE_NONE) {
            stp_boxd box = d->nodes[d->root].bounds;
            stp_vec3d half = stp_scaled(stp_subd(box.max, box.min), 0.5);
            stp_view view = {.target = stp_addd(box.min, half),
                             .up = {0, 1, 0},
                             .fov_degrees = 60,
                             .width = 200,
                             .height = 200};
            view.eye = view.target;
            view.eye.z += 10.0 * (half.x + half.y + half.z) + 1.0;
            uint32_t count = splat_count_of_scene(store, 0);
            CHECK_EQUAL(count_drawn(context, store, &view), count);
            with_splats += count > 0;
        }
        stp_store_close(store);
        stp_context_destroy(context);
    }
    CHECK(with_splats > 6);
}

void test_viewer_splat_count_steps_from_two_to_all(test_state* test)
{
    CHECK_EQUAL(2, splat_count_within(0, 1000));
    CHECK_EQUAL(2, splat_count_within(1, 1000));
    CHECK_EQUAL(500, splat_count_within(500, 1000));
    CHECK_EQUAL(1000, splat_count_within(UINT64_MAX, 1000));
    CHECK_EQUAL(200, splat_count_step(100, 1000, true, false));
    CHECK_EQUAL(50, splat_count_step(100, 1000, false, false));
    CHECK_EQUAL(105, splat_count_step(100, 1000, true, true));
    CHECK_EQUAL(95, splat_count_step(100, 1000, false, true));
    CHECK_EQUAL(3, splat_count_step(2, 1000, true, true)); // at least one
    CHECK_EQUAL(2, splat_count_step(3, 1000, false, true));
    CHECK_EQUAL(SPLAT_COUNT_MAX,
                splat_count_step(SPLAT_COUNT_MAX - 1, SPLAT_COUNT_MAX, true, false));
    for (int fine = 0; fine < 2; ++fine) { // repeated steps up reach all, steps down two
        uint32_t count = 2;
        for (int i = 0; i < 600 && count < SPLAT_COUNT_MAX; ++i) {
            uint32_t next = splat_count_step(count, SPLAT_COUNT_MAX, true, fine == 1);
            CHECK(next > count);
            count = next;
        }
        CHECK_EQUAL(SPLAT_COUNT_MAX, count);
        for (int i = 0; i < 600 && count > 2; ++i) {
            uint32_t next = splat_count_step(count, SPLAT_COUNT_MAX, false, fine == 1);
            CHECK(next < count);
            count = next;
        }
        CHECK_EQUAL(2, count);
    }
    CHECK(splat_count_is_chosen_of(3) && !splat_count_is_chosen_of(2));
}
