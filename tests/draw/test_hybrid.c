// SPDX-License-Identifier: MIT
// Large triangles drawn beside splats: which splats they replace, and pictures without holes on
// both backends.
#include "support_gl.h"
#include "support_store.h"
#include "tests.h"

#include "base/math/position_grid.h"
#include "base/splats/splat_codes.h"
#include "base/splats/triangle_level.h"
#include "lod/set_columns.h"
#include "lod/spt/spt_set.h"
#include "store/clusters/clusters.h"
#include "store/sets/large_triangles.h"

#include <stdlib.h>
#include <string.h>

enum { SIDE = 128, LOG_SIDE = 6, ROWS = 40, SMALL = 2 * ROWS * ROWS };

// The square from -1 to 1: two triangles left of x = 0, thousands to its right.
typedef struct half_and_half {
    float positions[3 * (4 + (ROWS + 1) * (ROWS + 1))];
    uint32_t indices[3 * (2 + SMALL)];
    float corners[18]; ///< corners of the two triangles
} half_and_half;

typedef struct fixture {
    stp_context* context;
    half_and_half mesh;
    made_scene scene;
    stp_coded_mesh coded;
    stp_splats samples, set;
    stp_store* store;
    stp_draw_list list;
    stp_view view;
    stp_quality quality;
} fixture;

static void add_triangle(half_and_half* m, uint32_t* count, uint32_t a, uint32_t b, uint32_t c)
{
    const uint32_t corners[3] = {a, b, c};
    memcpy(m->indices + 3 * (size_t)*count, corners, sizeof(corners));
    *count += 1;
}

static void make_mesh(half_and_half* m)
{
    static const float large[12] = {-1, -1, 0, 0, -1, 0, -1, 1, 0, 0, 1, 0};
    uint32_t count = 0;
    memcpy(m->positions, large, sizeof(large));
    add_triangle(m, &count, 0, 1, 2);
    add_triangle(m, &count, 1, 3, 2);
    for (uint32_t i = 0; i < 6; ++i) {
        memcpy(m->corners + 3 * i, large + 3 * m->indices[i], 3 * sizeof(float));
    }
    for (uint32_t y = 0; y <= ROWS; ++y) {
        for (uint32_t x = 0; x <= ROWS; ++x) {
            float* p = m->positions + 3 * (size_t)(4 + y * (ROWS + 1) + x);
            p[0] = (float)x / ROWS;
            p[1] = 2.0f * (float)y / ROWS - 1.0f;
            p[2] = 0.0f;
        }
    }
    for (uint32_t y = 0; y < ROWS; ++y) {
        for (uint32_t x = 0; x < ROWS; ++x) {
            uint32_t at = 4 + y * (ROWS + 1) + x;
            add_triangle(m, &count, at, at + 1, at + ROWS + 1);
            add_triangle(m, &count, at + 1, at + ROWS + 2, at + ROWS + 1);
        }
    }
}

/// @param away distance of the set's large triangles from the mesh. Above 0, they replace no splat,
/// and no flat part ends the tree; 0: they are the same
static bool set_up_away(fixture* f, float away)
{
    static const uint8_t red[3] = {255, 0, 0};
    *f = (fixture){.context = test_context(NULL, 2, NULL)};
    make_mesh(&f->mesh);
    for (int i = 0; i < 18; i += 3) {
        f->mesh.corners[i] += away;
    }
    f->samples = made_square_set(f->context, LOG_SIDE, red);
    const stp_spt_desc desc = {.tree = {away > 0.0f ? STP_TREE_DIAMETER : STP_TREE_GEOMETRIC, 255},
                               .corners = f->mesh.corners,
                               .triangle_count = 2};
    const stp_store_mesh mesh = {.vertex_count = 4 + (ROWS + 1) * (ROWS + 1),
                                 .triangle_count = 2 + SMALL,
                                 .positions = f->mesh.positions,
                                 .indices = f->mesh.indices,
                                 .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    double step = stp_choose_grid_step(f->mesh.positions, f->mesh.indices, 2 + SMALL);
    if (stp_spt_make(f->context, &f->samples, &desc, &f->set) != STP_OK ||
        stp_clusters_encode(f->context, &mesh, step, &f->coded) != STP_OK) {
        return false;
    }
    made_one_node(&f->scene, &mesh, &f->set);
    f->scene.materials[0].base_color[1] = f->scene.materials[0].base_color[2] = 0.0f;
    f->scene.coded_meshes = &f->coded;
    f->store = made_open(f->context, &f->scene);
    f->view = (stp_view){
        .eye = {0, 0, 6}, .up = {0, 1, 0}, .fov_degrees = 60, .width = SIDE, .height = SIDE};
    f->quality = (stp_quality){.splat_size = 1.0f, .early_switch = 1};
    return f->store != NULL;
}

static bool set_up(fixture* f)
{
    return set_up_away(f, 0.0f);
}

static void tear_down(fixture* f)
{
    stp_draw_list_destroy(f->context, &f->list);
    stp_store_close(f->store);
    stp_coded_mesh_destroy(f->context, &f->coded);
    made_free_set(f->context, &f->samples);
    stp_splats_destroy(f->context, &f->set);
    stp_context_destroy(f->context);
}

static stp_result draw(fixture* f, stp_renderer* renderer, uint8_t* pixels, stp_draw_stats* stats)
{
    stp_image image = {SIDE, SIDE, pixels};
    return stp_renderer_draw(renderer, &f->view, &f->list, &(stp_draw_style){0}, &image, stats);
}

static stp_result select_items(fixture* f)
{
    return stp_select(f->context, f->store, &f->view, &f->quality, &f->list);
}

// Number of uncovered pixels of one half of the square, without its outer edge.
static int count_holes(const fixture* f, const uint8_t* pixels, bool left)
{
    double half =
        0.5 * SIDE / (f->view.eye.z * 0.57735026918962576); // half the square's side, in pixels
    int begin = (int)(0.5 * SIDE - half) + 2, end = (int)(0.5 * SIDE + half) - 2, count = 0;
    for (int y = begin; y < end; ++y) {
        for (int x = left ? begin : SIDE / 2; x < (left ? SIDE / 2 : end); ++x) {
            count += pixels[4 * (y * SIDE + x) + 3] == 0 ? 1 : 0;
        }
    }
    return count;
}

void test_hybrid_marks_splats_amid_large_triangles(test_state* test)
{
    static fixture f;
    CHECK(set_up(&f));
    float level =
        stp_triangle_level((stp_vec3){-1, -1, 0}, (stp_vec3){0, -1, 0}, (stp_vec3){-1, 1, 0});
    CHECK(level > 1.117f && level < 1.119f);
    uint32_t marked = 0, left = 0;
    for (uint32_t i = 0; i < f.set.count; ++i) {
        float x = f.set.origin.x + f.set.step * (float)f.set.positions[3 * (size_t)i];
        float highest = stp_range_level(f.set.ranges[i] >> 16);
        bool replaced = stp_shape_is_replaced(f.set.shapes[i]);
        // splats beside small triangles stay, and so do splats that any level draws without
        // triangles
        CHECK(!replaced || (x < 0.0f && highest < level));
        left += x < -0.35f && highest < 0.1f ? 1 : 0;
        marked += replaced && x < -0.35f && highest < 0.1f ? 1 : 0;
    }
    CHECK(left > 1000 && marked == left);
    tear_down(&f);
}

void test_hybrid_lists_large_triangles(test_state* test)
{
    static fixture f;
    CHECK(set_up(&f));
    stp_large_triangles list;
    // a lower level lists more, each with its own size; listed triangles stay
    uint32_t before = 0;
    stp_large_triangles first = {0};
    static const float leasts[] = {2.0f, 1.0f, 0.5f, 0.02f, 0.005f, 0.0f};
    for (size_t k = 0; k < sizeof(leasts) / sizeof(leasts[0]); ++k) {
        CHECK_EQUAL(STP_OK, stp_store_get_large_triangles(f.store, 0, leasts[k], &list));
        CHECK(list.count >= before);
        before = list.count;
        first = k == 1 ? list : first;
    }
    CHECK(first.count == 2 && first.levels[0] > 1.1f && first.levels[1] > 1.1f);
    CHECK_EQUAL(2 + SMALL, list.count);
    stp_clusters clusters;
    stp_decoded_mesh decoded;
    CHECK_EQUAL(STP_OK, stp_store_get_clusters(f.store, 0, &clusters));
    CHECK_EQUAL(STP_OK, stp_clusters_decode(f.context, &clusters, &decoded));
    uint8_t* seen = calloc(list.count, 1);
    CHECK(seen != NULL);
    for (uint32_t i = 0; i < list.count; ++i) {
        const float* p = decoded.positions + 9 * (size_t)list.triangles[i];
        float level = stp_triangle_level((stp_vec3){p[0], p[1], p[2]}, (stp_vec3){p[3], p[4], p[5]},
                                         (stp_vec3){p[6], p[7], p[8]});
        CHECK(level == list.levels[i] && seen[list.triangles[i]]++ == 0);
    }
    // a search finds them all, and few others
    for (float level = 0.001f; level < 3.0f; level *= 1.3f) {
        uint32_t count = stp_large_triangles_find(&list, level);
        for (uint32_t i = 0; i < list.count; ++i) {
            CHECK(i >= count ? list.levels[i] < level : list.levels[i] >= 0.66f * level);
        }
    }
    CHECK_EQUAL(list.count, stp_large_triangles_find(&list, 0.0f));
    free(seen);
    stp_decoded_mesh_destroy(f.context, &decoded);
    tear_down(&f);
}

void test_hybrid_draws_without_holes(test_state* test)
{
    static fixture f;
    static uint8_t pixels[SIDE * SIDE * 4];
    stp_renderer* renderer = NULL;
    stp_draw_stats stats;
    CHECK(set_up(&f));
    CHECK_EQUAL(STP_OK, stp_draw_cpu_create(f.context, f.store, &renderer));
    int beside = 0, holes = 0;
    for (int i = 0; i < 20; ++i) {
        f.view.eye.z = 5.0 * pow(1.08, i);
        f.quality.splat_size = (float)(1 + i % 6);
        f.quality.nodes_only = false;
        CHECK_EQUAL(STP_OK, select_items(&f));
        CHECK_EQUAL(STP_OK, draw(&f, renderer, pixels, &stats));
        CHECK(count_holes(&f, pixels, true) == 0 && count_holes(&f, pixels, false) == 0);
        bool large = f.list.count == 2 && f.list.items[1].large;
        CHECK(f.list.items[0].beside_triangles == large);
        if (large) { // the two large triangles alone cover their half, and nothing of the other one
            beside += 1;
            CHECK_EQUAL(2, stats.triangles);
            f.list.count = 1;
            CHECK_EQUAL(STP_OK, draw(&f, renderer, pixels, &stats));
            CHECK_EQUAL(0, count_holes(&f, pixels, false));
            holes += count_holes(&f, pixels, true);
        }
        f.quality.nodes_only = true;
        CHECK_EQUAL(STP_OK, select_items(&f));
        CHECK_EQUAL(STP_OK, draw(&f, renderer, pixels, &stats));
        CHECK(count_holes(&f, pixels, true) == 0 && !f.list.items[0].beside_triangles);
    }
    CHECK(beside > 8 && holes > 20 * beside);
    stp_renderer_destroy(renderer);
    tear_down(&f);
}

// The replaced splats are known even for octaves that no earlier picture has read.
void test_hybrid_reads_octaves_it_looks_at(test_state* test)
{
    static fixture f;
    CHECK(set_up_away(&f, 100.0f)); // no splat is replaced, so all are examined
    CHECK(f.set.octave_count > 3 && (f.set.columns & STP_SPLATS_REPLACED) != 0);
    uint32_t maximum = 0;
    for (int i = 0; i < 24; ++i) {
        f.view.eye.z = 2.0 * pow(1.3, i);
        for (uint32_t k = 0; k <= f.set.octave_count; ++k) {
            stp_splats got;
            stp_store_release_splat_set(f.store, 0);
            CHECK_EQUAL(STP_OK, stp_store_get_splat_set_prefix(f.store, 0, k, &got));
            CHECK_EQUAL(STP_OK, select_items(&f));
            CHECK(f.list.count == 1 && !f.list.items[0].beside_triangles);
            maximum = f.list.items[0].prefix > maximum ? f.list.items[0].prefix : maximum;
        }
    }
    CHECK(maximum > f.set.octave_ends[1]);
    tear_down(&f);
}

// Nothing is drawn twice where a set draws only part of its node, or draws it modified.
void test_hybrid_leaves_out_hidden_triangles(test_state* test)
{
    static fixture f;
    CHECK(set_up(&f));
    f.view.eye.z = 12.0;
    f.quality.splat_size = 2.0f;
    CHECK_EQUAL(STP_OK, select_items(&f));
    CHECK(f.list.count == 2 && f.list.items[1].large);
    stp_quality usual = f.quality;
    f.quality.splats_only = true;
    CHECK_EQUAL(STP_OK, select_items(&f));
    CHECK(f.list.count == 1 && !f.list.items[0].beside_triangles);
    f.quality = usual;
    f.quality.splat_count = 500;
    CHECK_EQUAL(STP_OK, select_items(&f));
    CHECK(f.list.count == 1 && !f.list.items[0].beside_triangles);
    f.quality = usual;
    f.view.sections =
        (stp_sections){.count = 1, .planes = {{.normal = {1, 0, 0}, .distance = 0.5}}};
    CHECK_EQUAL(STP_OK, select_items(&f));
    CHECK(f.list.count == 1 && !f.list.items[0].beside_triangles);
    tear_down(&f);
}

void test_hybrid_looks_alike_in_opengl(test_state* test)
{
    static made_gl m;
    static fixture f;
    static uint8_t cpu[SIDE * SIDE * 4], gl[SIDE * SIDE * 4];
    bool failed = false;
    if (!made_gl_begin(&m, true, &failed)) {
        made_gl_end(&m);
        CHECK(!failed);
        test->skipped = "there is no OpenGL";
        return;
    }
    CHECK(set_up(&f));
    stp_renderer *one = NULL, *other = NULL;
    stp_draw_stats stats;
    const stp_draw_gl_desc desc = {
        .get_proc_address = stp_headless_get_proc_address, .user = &m.headless, .debug = true};
    CHECK_EQUAL(STP_OK, stp_draw_cpu_create(f.context, f.store, &one));
    CHECK_EQUAL(STP_OK, stp_draw_gl_create(f.context, f.store, &desc, &other));
    for (int i = 0; i < 4; ++i) {
        f.view.eye.z = 6.0 + 3.0 * i;
        f.quality.splat_size = 3.0f;
        CHECK_EQUAL(STP_OK, select_items(&f));
        CHECK(f.list.count == 2 && f.list.items[1].large);
        CHECK_EQUAL(STP_OK, draw(&f, one, cpu, &stats));
        CHECK_EQUAL(STP_OK, draw(&f, other, gl, &stats));
        CHECK_EQUAL(2, stats.triangles);
        CHECK(count_holes(&f, gl, true) == 0 && count_holes(&f, gl, false) == 0);
        CHECK(made_count_different(cpu, gl, 6) < SIDE * SIDE / 200);
        f.list.count = 1;
        CHECK_EQUAL(STP_OK, draw(&f, other, gl, &stats));
        CHECK(count_holes(&f, gl, false) == 0);
    }
    stp_renderer_destroy(one);
    stp_renderer_destroy(other);
    tear_down(&f);
    made_gl_end(&m);
}

void test_hybrid_survives_lack_of_memory(test_state* test)
{
    static fixture f;
    static uint8_t pixels[SIDE * SIDE * 4];
    CHECK(set_up(&f));
    f.view.eye.z = 12.0;
    f.quality.splat_size = 2.0f;
    bool done = false;
    for (int n = 1; !done && n < 2000; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_renderer* renderer = NULL;
        stp_draw_stats stats;
        stp_store* store = context != NULL ? made_open(context, &f.scene) : NULL;
        stp_image image = {SIDE, SIDE, pixels};
        stp_draw_list list = {0};
        bool drawn = store != NULL && stp_draw_cpu_create(context, store, &renderer) == STP_OK &&
                     stp_select(context, store, &f.view, &f.quality, &list) == STP_OK &&
                     stp_renderer_draw(renderer, &f.view, &list, &(stp_draw_style){0}, &image,
                                       &stats) == STP_OK;
        CHECK(!drawn || count_holes(&f, pixels, true) == 0);
        done = drawn && heap.count <= n; // the failing allocation was not reached
        stp_renderer_destroy(renderer);
        stp_draw_list_destroy(context, &list);
        stp_store_close(store);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(done);
    tear_down(&f);
}
