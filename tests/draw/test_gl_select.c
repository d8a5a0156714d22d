// SPDX-License-Identifier: MIT
// The list that compute shaders make is the processor's, as a set: the same things in the same places, the same prefixes
// and runs, the same depths but for what the last digits of doubles decide.
#include "tests.h"

#include "base/rng.h"
#include "draw/gl/select_pass.h"
#include "draw/support_store.h"
#include "present/headless.h"

#include <string.h>

enum { VIEWS = 60, PYRAMID_VIEWS = 30, WIDTH = 640, HEIGHT = 400 };

typedef struct selecting {
    stp_headless headless;
    stp_context* context;
    made_scene scene;
    stp_store* store;
    stp_gl gl;
    gl_select_pass pass;
    stp_draw_list cpu, gpu;
} selecting;

static stp_affine place(double x, double y, double z, double scale)
{
    stp_affine a = stp_affine_identity();
    for (int i = 0; i < 3; ++i) {
        a.m[i][i] = scale;
    }
    a.m[0][3] = x;
    a.m[1][3] = y;
    a.m[2][3] = z;
    return a;
}

// A square with surfels, twice in a node that has surfels too, that twice again, and so on; one of all that moves.
static void make_scene(stp_context* context, made_scene* s)
{
    static const uint8_t color[3] = {90, 90, 90};
    *s = (made_scene){.node_count = 5, .part_count = 1, .material_count = 1, .mesh_count = 1};
    s->shading_count = 1;
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->materials[0] = made_material();
    s->meshes[0] = made_square(0);
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    double half = 1.0;
    for (uint32_t i = 0; i < 5; ++i) {
        s->nodes[i] = (stp_store_node){.first_edge = s->edge_count,
                                       .edge_count = i > 0 ? 2 : 0,
                                       .part_count = i == 0 ? 1 : 0,
                                       .surfels = i < 4 ? i : STP_STORE_NONE,
                                       .flags = i == 1 ? 1 : 0,
                                       .triangle_count = 2u << i,
                                       .bounds = {{-half, -half, -0.5}, {half, half, 0.5}}};
        if (i > 0) {
            s->edges[s->edge_count++] = (stp_store_edge){i - 1, place(-half / 2, 0.1, 0.1, 0.5)};
            s->edges[s->edge_count++] =
                (stp_store_edge){i - 1, place(half / 2, i * 0.2, -0.3, 0.5)};
        }
        if (i < 4) {
            s->surfels[s->surfels_count++] = made_square_surfels(context, i == 3 ? 6 : 5, color);
        }
    }
    s->nodes[4].bounds = (stp_boxd){{-3, -3, -3}, {3, 3, 3}};
}

static bool begin(selecting* s, bool* failed)
{
    const stp_headless_desc wanted = {.debug = true};
    const stp_draw_gl_desc desc = {.get_proc_address = stp_headless_get_proc_address,
                                   .user = &s->headless};
    *s = (selecting){.store = NULL};
    *failed = false;
    if (stp_headless_create(&wanted, &s->headless) != NULL) {
        return false;
    }
    *failed = true;
    s->context = test_context(NULL, 2, NULL);
    make_scene(s->context, &s->scene);
    s->store = made_open(s->context, &s->scene);
    *failed = s->store == NULL || stp_gl_load(&s->gl, &desc) != NULL ||
              gl_select_create(s->context, &s->gl, s->store, &s->pass) != STP_OK;
    return !*failed;
}

static void end(selecting* s)
{
    gl_select_destroy(&s->pass);
    if (s->context != NULL) {
        stp_draw_list_destroy(s->context, &s->cpu);
        stp_draw_list_destroy(s->context, &s->gpu);
        for (uint32_t i = 0; i < s->scene.surfels_count; ++i) {
            made_free_surfels(s->context, &s->scene.surfels[i]);
        }
        if (s->store != NULL) {
            stp_store_close(s->store);
        }
        stp_context_destroy(s->context);
    }
    if (s->headless.context != NULL) {
        stp_headless_destroy(&s->headless);
    }
}

static double draw_number(uint64_t* seed, double low, double high)
{
    return low + (high - low) * (double)(stp_rng_hash(11, (*seed)++) >> 11) * 0x1p-53;
}

static stp_view make_view(uint64_t number)
{
    uint64_t seed = 100 * number;
    double far = number % 3 == 0 ? 1.5 : number % 3 == 1 ? 6.0 : 40.0;
    stp_view view = {.width = WIDTH, .height = HEIGHT, .up = {0.1, 1, 0}, .fov_degrees = 60};
    view.eye = (stp_vec3d){draw_number(&seed, -far, far), draw_number(&seed, -far, far),
                           draw_number(&seed, -far, far)};
    view.target = (stp_vec3d){draw_number(&seed, -1, 1), draw_number(&seed, -1, 1),
                              draw_number(&seed, -1, 1)};
    view.ortho_height = number % 7 == 3 ? far : 0.0;
    return view;
}

static bool is_close(float a, float b)
{
    return a == b || fabsf(a - b) <= 1e-5f * fabsf(a);
}

static bool is_same(const selecting* s, const stp_draw_item* a, const stp_draw_item* b)
{
    double apart = 0.0;
    for (int r = 0; r < 3; ++r) {
        for (int c = 0; c < 4; ++c) {
            apart = fmax(apart, fabs(a->transform.m[r][c] - b->transform.m[r][c]));
        }
    }
    bool same = a->kind == b->kind && a->index == b->index && apart < 1e-12 &&
                a->prefix == b->prefix && a->full_prefix == b->full_prefix &&
                a->run_count == b->run_count && is_close(a->radius, b->radius) &&
                is_close(a->fade_begin, b->fade_begin) && is_close(a->fade_end, b->fade_end);
    for (uint32_t i = 0; i < a->run_count && same; ++i) {
        const stp_draw_run* x = &s->cpu.runs[a->first_run + i];
        const stp_draw_run* y = &s->gpu.runs[b->first_run + i];
        same = x->end == y->end && is_close(x->nearest, y->nearest) &&
               is_close(x->farthest, y->farthest);
    }
    return same;
}

/// Items of the processor's list that the other one has not.
static size_t count_missing(const selecting* s)
{
    size_t missing = 0;
    for (size_t i = 0; i < s->cpu.count; ++i) {
        bool found = false;
        for (size_t k = 0; k < s->gpu.count && !found; ++k) {
            found = is_same(s, &s->cpu.items[i], &s->gpu.items[k]);
        }
        missing += found ? 0 : 1;
    }
    return missing;
}

static uint32_t count_commands(const stp_draw_list* list, bool meshes)
{
    uint32_t count = 0;
    for (size_t i = 0; i < list->count; ++i) {
        const stp_draw_item* item = &list->items[i];
        uint32_t runs = item->run_count > 0 ? item->run_count : 1;
        count += (item->kind == STP_DRAW_MESH) == meshes ? runs : 0;
    }
    return count;
}

static void compare(test_state* test, selecting* s, const stp_view* view,
                    const stp_quality* quality, uint32_t* runs)
{
    gl_select_counts counts;
    CHECK(gl_select_can(view, quality));
    CHECK_EQUAL(STP_OK, stp_select(s->context, s->store, view, quality, &s->cpu));
    CHECK_EQUAL(STP_OK, gl_select_run(&s->pass, view, quality));
    CHECK_EQUAL(STP_OK, gl_select_read(&s->pass, &s->gpu, &counts));
    CHECK_EQUAL(GL_NO_ERROR, s->gl.GetError());
    CHECK_EQUAL(s->cpu.count, s->gpu.count);
    CHECK_EQUAL(0, count_missing(s));
    CHECK_EQUAL(s->cpu.node_count, counts.visited);
    CHECK_EQUAL(s->cpu.hidden_count, counts.hidden);
    CHECK_EQUAL(count_commands(&s->cpu, false), counts.splat_commands);
    CHECK_EQUAL(count_commands(&s->cpu, true), counts.triangle_commands);
    *runs += counts.runs;
}

void test_gl_select_gives_the_processors_list(test_state* test)
{
    selecting s;
    bool failed;
    if (!begin(&s, &failed)) {
        end(&s);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    uint32_t runs = 0;
    for (uint32_t i = 0; i < VIEWS; ++i) {
        stp_view view = make_view(i);
        stp_quality quality = {.splat_size = i % 2 == 0 ? 1.0f : 3.0f,
                               .spare = i % 3 == 0 ? 0.0f : 1.0f};
        compare(test, &s, &view, &quality, &runs);
    }
    CHECK(runs > 100);
    end(&s);
}

void test_gl_select_leaves_out_what_is_hidden(test_state* test)
{
    static float nearness[WIDTH * HEIGHT];
    selecting s;
    bool failed;
    if (!begin(&s, &failed)) {
        end(&s);
        CHECK(!failed);
        SKIP("there is no OpenGL");
    }
    stp_depth_pyramid pyramid = {.level_count = 0};
    uint64_t hidden = 0;
    uint32_t runs = 0;
    for (uint32_t i = 0; i < PYRAMID_VIEWS; ++i) {
        stp_view view = make_view(3 * i + 1), before = make_view(3 * i + 1);
        view.ortho_height = before.ortho_height = 0.0;
        view.eye.x += 0.05;                             // not quite the view that the pyramid is of
        for (uint32_t k = 0; k < WIDTH * HEIGHT; ++k) { // a wall over the left or the upper part
            bool wall = i % 2 == 0 ? k % WIDTH < WIDTH * 3 / 4 : k / WIDTH < HEIGHT / 2;
            nearness[k] = wall ? 0.1f : 0.0f;
        }
        before.near_distance = view.near_distance = 0.2;
        CHECK_EQUAL(STP_OK, stp_depth_pyramid_make(s.context, &before, nearness, &pyramid));
        stp_quality quality = {.splat_size = 1, .occlusion = &pyramid};
        compare(test, &s, &view, &quality, &runs);
        hidden += s.cpu.hidden_count;
    }
    CHECK(hidden > 20);
    stp_depth_pyramid_destroy(s.context, &pyramid);
    end(&s);
}
