// SPDX-License-Identifier: MIT
// Zones of larger splats, and views of two eyes.
#include "fovea_factor.h"
#include "pyramid_helpers.h"
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "draw/support_store.h"
#include "select/select.h"

static double uniform(uint64_t round, uint64_t number, double low, double high)
{
    return low + (high - low) * ((double)(stp_rng_hash(round, number) >> 11) * 0x1p-53);
}

static stp_fovea random_fovea(uint64_t round)
{
    stp_fovea fovea = {.count = 1 + (uint32_t)(round % STP_FOVEA_ZONES)};
    double radius = round % 3 == 0 ? 0.0 : uniform(round, 100, 0.05, 0.3);
    for (uint32_t i = 0; i < fovea.count; ++i) {
        fovea.zones[i].radius = (float)radius;
        fovea.zones[i].factor = (float)uniform(round, 200 + i, 0.5, 6.0);
        radius += uniform(round, 300 + i, 0.02, 0.3);
    }
    if (round % 2 == 0) {
        fovea.center[0] = (float)uniform(round, 400, -0.7, 0.7);
        fovea.center[1] = (float)uniform(round, 401, -0.7, 0.7);
    }
    return fovea;
}

static stp_view random_view(uint64_t round)
{
    return (stp_view){.eye = {uniform(round, 0, -2.0, 2.0), uniform(round, 1, -2.0, 2.0),
                              uniform(round, 2, -2.0, 2.0)},
                      .target = {uniform(round, 3, 3.0, 4.0), uniform(round, 4, -2.0, 2.0), 0},
                      .up = {0, 0, 1},
                      .ortho_height = round % 7 == 0 ? 3.0 : 0.0,
                      .fov_degrees = uniform(round, 5, 20.0, 110.0),
                      .near_distance = 0.05,
                      .width = 300,
                      .height = 200};
}

void test_fovea_factor_meets_its_zones_and_never_jumps(test_state* test)
{
    for (uint64_t round = 0; round < 60; ++round) {
        stp_fovea fovea = random_fovea(round);
        CHECK(stp_fovea_is_valid(&fovea));
        CHECK(fovea.zones[0].radius <= 0.0f || fovea_factor_at(&fovea, 0.0) == 1.0);
        for (uint32_t i = 0; i < fovea.count; ++i) {
            stp_fovea_zone zone = fovea.zones[i];
            CHECK(fovea_factor_at(&fovea, (double)zone.radius) == (double)zone.factor);
        }
        double last = fovea_factor_at(&fovea, 0.0);
        for (int i = 1; i <= 20000; ++i) { // the steepest zone has 5.5 over 0.02
            double now = fovea_factor_at(&fovea, 1e-4 * i);
            CHECK(fabs(now - last) < 0.0276);
            last = now;
        }
        CHECK(fovea_factor_at(&fovea, 1e9) == (double)fovea.zones[fovea.count - 1].factor);
    }
    const stp_fovea none = {0};
    CHECK(fovea_factor_at(&none, 0.7) == 1.0);
}

void test_fovea_refuses_invalid_zones(test_state* test)
{
    const stp_fovea bad[] = {
        {.count = 2, .zones = {{0.5f, 2}, {0.5f, 3}}},
        {.count = 1, .zones = {{-0.1f, 2}}},
        {.count = 1, .zones = {{0.5f, 0}}},
        {.count = 1, .zones = {{0.5f, NAN}}},
        {.count = 1, .zones = {{INFINITY, 1}}},
        {.count = STP_FOVEA_ZONES + 1},
        {.center = {NAN, 0}},
    };
    for (size_t i = 0; i < sizeof(bad) / sizeof(bad[0]); ++i) {
        CHECK(!stp_fovea_is_valid(&bad[i]));
    }
}

// Minimum and maximum factor in a rectangle, against brute force over its points.
void test_fovea_bounds_are_those_of_all_pixels(test_state* test)
{
    for (uint64_t round = 0; round < 200; ++round) {
        stp_fovea fovea = random_fovea(round);
        stp_view view = random_view(round);
        stp_view_frame frame;
        CHECK(stp_view_frame_make(&view, &frame));
        stp_view_rectangle r = {.x0 = uniform(round, 10, 0.0, 250.0),
                                .y0 = uniform(round, 11, 0.0, 150.0)};
        r.x1 = r.x0 + uniform(round, 12, 0.0, 50.0);
        r.y1 = r.y0 + uniform(round, 13, 0.0, 50.0);
        double minimum, greatest, low = HUGE_VAL, high = 0.0;
        stp_fovea_bound(&fovea, &frame, &r, &minimum, &greatest);
        double half = 0.5 * sqrt(300.0 * 300.0 + 200.0 * 200.0);
        for (int i = 0; i < 101 * 101; ++i) {
            double x = r.x0 + (r.x1 - r.x0) * 0.01 * (i % 101);
            double y = r.y0 + (r.y1 - r.y0) * 0.01 * (double)(i / 101);
            double dx = (x - 150.0) / half - (double)fovea.center[0];
            double dy = (y - 100.0) / half - (double)fovea.center[1];
            double factor = fovea_factor_at(&fovea, sqrt(dx * dx + dy * dy));
            CHECK(factor >= minimum - 1e-9 && factor <= greatest + 1e-9);
            low = fmin(low, factor);
            high = fmax(high, factor);
        }
        // off by at most one sampling step
        CHECK(low - minimum < 275.0 * 0.71 / half && greatest - high < 275.0 * 0.71 / half);
    }
}

static stp_boxd random_box(uint64_t round)
{
    stp_boxd box;
    box.min = (stp_vec3d){uniform(round, 20, -3.0, 3.0), uniform(round, 21, -3.0, 3.0),
                          uniform(round, 22, -3.0, 3.0)};
    box.max = (stp_vec3d){box.min.x + uniform(round, 23, 0.0, 3.0),
                          box.min.y + uniform(round, 24, 0.0, 3.0),
                          box.min.z + uniform(round, 25, 0.0, 3.0)};
    return box;
}

// The visible part of a box is in its rectangle, which moves little when the view moves little.
void test_fovea_rectangle_holds_the_picture_of_a_box(test_state* test)
{
    int seen = 0, moved = 0;
    for (uint64_t round = 0; round < 400; ++round) {
        stp_view view = random_view(round);
        stp_boxd box = random_box(round);
        stp_view_frame f;
        CHECK(stp_view_frame_make(&view, &f));
        stp_view_rectangle r = stp_view_frame_cover(&f, &box);
        CHECK(r.x0 >= 0.0 && r.x0 <= r.x1 && r.x1 <= 300.0);
        CHECK(r.y0 >= 0.0 && r.y0 <= r.y1 && r.y1 <= 200.0);
        for (int i = 0; i < 8 * 8 * 8; ++i) {
            stp_vec3d p = {box.min.x + (box.max.x - box.min.x) * (i % 8) / 7.0,
                           box.min.y + (box.max.y - box.min.y) * (i / 8 % 8) / 7.0,
                           box.min.z + (box.max.z - box.min.z) * (double)(i / 64) / 7.0};
            p = stp_subd(p, f.eye);
            double z = f.parallel ? 1.0 : stp_dotd(f.forward, p);
            double x = f.center_x + f.scale * stp_dotd(f.right, p) / z;
            double y = f.center_y + f.scale * stp_dotd(f.down, p) / z;
            if (z < f.near_distance || x < 0 || x > 300 || y < 0 || y > 200) {
                continue;
            }
            CHECK(x >= r.x0 - 1e-6 && x <= r.x1 + 1e-6 && y >= r.y0 - 1e-6 && y <= r.y1 + 1e-6);
            seen += 1;
        }
        for (int k = 0; k < 20; ++k) { // sideways, so that corners pass the near plane
            view.eye.x += 1e-6;
            CHECK(stp_view_frame_make(&view, &f));
            stp_view_rectangle next = stp_view_frame_cover(&f, &box);
            double maximum = fmax(fmax(fabs(next.x0 - r.x0), fabs(next.x1 - r.x1)),
                                  fmax(fabs(next.y0 - r.y0), fabs(next.y1 - r.y1)));
            CHECK(maximum < 0.6); // near points move that fast: 1e-6 of 0.05 at 1e3 pixels a unit
            moved += maximum > 0.0;
            r = next;
        }
    }
    CHECK(seen > 5000 && moved > 1000);
}

void test_eyes_look_in_parallel_from_beside_the_view(test_state* test)
{
    for (uint64_t round = 1; round < 50; ++round) {
        stp_view view = random_view(round);
        stp_view_frame whole, eyes[STP_EYES_MAX];
        CHECK_EQUAL(1, stp_view_eye_count(&view));
        stp_view same = stp_view_of_eye(&view, 0);
        CHECK(memcmp(&same.eye, &view.eye, sizeof(view.eye)) == 0 && same.width == view.width);
        CHECK(stp_view_frame_make(&view, &whole));
        view.eye_distance = 0.2;
        CHECK(!stp_view_frame_make(&view, &whole)); // each eye has its own gaze
        CHECK_EQUAL(2, stp_view_eye_count(&view));
        for (uint32_t i = 0; i < 2; ++i) {
            stp_view one = stp_view_of_eye(&view, i);
            CHECK_EQUAL(150, one.width);
            CHECK_EQUAL(200, one.height);
            CHECK(stp_view_frame_make(&one, &eyes[i]));
            CHECK(fabs(stp_dotd(eyes[i].forward, eyes[0].forward) - 1.0) < 1e-12);
        }
        stp_vec3d across = stp_subd(eyes[1].eye, eyes[0].eye);
        CHECK(fabs(stp_dotd(across, eyes[0].right) - 0.2) < 1e-12);
        CHECK(fabs(stp_dotd(across, eyes[0].forward)) < 1e-12);
        stp_vec3d middle = stp_scaled(stp_addd(eyes[0].eye, eyes[1].eye), 0.5);
        middle = stp_subd(middle, view.eye);
        CHECK(stp_dotd(middle, middle) < 1e-24);
    }
}

// A square with splats, and its triangles.
static stp_store* open_square(stp_context* context, made_scene* s)
{
    static const uint8_t grey[3] = {128, 128, 128};
    *s = (made_scene){.node_count = 1,
                      .part_count = 1,
                      .mesh_count = 1,
                      .material_count = 1,
                      .shading_count = 1,
                      .set_count = 1};
    s->materials[0] = made_material();
    s->shadings[0] = (stp_shading){.roughness = 1};
    s->meshes[0] = made_square(0);
    s->sets[0] = made_square_set(context, 6, grey);
    s->parts[0] = (stp_store_part){STP_STORE_PART_MESH, 0};
    s->nodes[0] = (stp_store_node){
        .part_count = 1, .set = 0, .triangle_count = 2, .bounds = {{-1, -1, 0}, {1, 1, 0}}};
    return made_open(context, s);
}

// The farther from the middle, the fewer splats, continuously.
void test_fovea_thins_splats_at_the_border(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_scene scene;
    stp_store* store = open_square(context, &scene);
    CHECK(store != NULL);
    stp_draw_list list = {0};
    stp_quality quality = {.splat_size = 2,
                           .early_switch = 2,
                           .fovea = {.count = 2, .zones = {{0.25f, 2}, {1.0f, 4}}}};
    uint32_t last = 0, first = 0;
    for (int i = 0; i <= 400; ++i) { // parallel to the gaze: at one depth, ever further to the side
        stp_view view = {.eye = {-0.06 * i, 0, 50},
                         .target = {-0.06 * i, 0, 0},
                         .up = {0, 1, 0},
                         .fov_degrees = 30,
                         .width = 400,
                         .height = 200};
        CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
        CHECK_EQUAL(1, list.count);
        uint32_t count = list.items[0].prefix;
        CHECK(list.splat_size == 2.0f);
        if (i == 0) {
            stp_quality flat = {.splat_size = 2, .early_switch = 2};
            first = count;
            CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &flat, &list));
            CHECK_EQUAL(list.items[0].prefix, count);
        } else {
            CHECK(count <= last &&
                  (double)count > 0.6 * (double)last); // its orders are of whole octaves
        }
        last = count;
    }
    CHECK(last * 8 < first && last > 0);
    // the zone they look at compensates for it
    stp_view view = {.eye = {-10, 0, 50},
                     .target = {-10, 0, 0},
                     .up = {0, 1, 0},
                     .fov_degrees = 30,
                     .width = 400,
                     .height = 200};
    quality.fovea.center[0] = (float)(10.0 / 50.0 / tan(STP_PI / 12.0) / sqrt(5.0));
    CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
    CHECK_EQUAL(first, list.items[0].prefix);
    quality.fovea.zones[1].radius = 0.1f;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_select(context, store, &view, &quality, &list));
    stp_draw_list_destroy(context, &list);
    made_free_set(context, &scene.sets[0]);
    stp_store_close(store);
    stp_context_destroy(context);
}

// Content seen by one or both eyes is in the list. Content hidden by the pyramid of only one eye is
// not hidden.
void test_eyes_share_what_either_needs(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_scene scene;
    stp_store* store = open_square(context, &scene);
    CHECK(store != NULL);
    stp_draw_list list = {0};
    int by_one = 0, by_both = 0;
    for (uint64_t round = 1; round < 300; ++round) {
        stp_view view = random_view(round);
        view.ortho_height = 0.0;
        view.eye.x -= 4.0;
        view.fov_degrees = uniform(round, 5, 5.0, 30.0);
        view.target.x -= 5.0;
        view.eye_distance = uniform(round, 30, 0.1, 5.0);
        stp_quality quality = {.splat_size = 3};
        uint32_t counts[3], nodes = 0;
        for (uint32_t i = 0; i < 3; ++i) {
            stp_view one = i < 2 ? stp_view_of_eye(&view, i) : view;
            CHECK_EQUAL(STP_OK, stp_select(context, store, &one, &quality, &list));
            counts[i] = list.count > 0 ? list.items[0].prefix : 0;
            nodes += i < 2 && list.count > 0;
        }
        CHECK_EQUAL(nodes > 0, list.count > 0);
        CHECK(list.triangle_count > 0 || (counts[2] >= counts[0] && counts[2] >= counts[1]));
        by_one += nodes == 1;
        by_both += nodes == 2;
    }
    CHECK(by_one > 10 && by_both > 50);
    stp_view view = random_view(1);
    for (int i = 0; i < 3; ++i) {
        stp_quality quality = {.splat_size = 1};
        view.eye_distance = i == 0 ? -0.1 : i == 1 ? (double)NAN : HUGE_VAL;
        CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_select(context, store, &view, &quality, &list));
    }
    stp_draw_list_destroy(context, &list);
    made_free_set(context, &scene.sets[0]);
    stp_store_close(store);
    stp_context_destroy(context);
}

// Each eye may have a wall in front of it: only content behind the walls of both is left out.
void test_eyes_hide_what_is_hidden_from_both(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    made_scene scene;
    stp_store* store = open_square(context, &scene);
    CHECK(store != NULL);
    stp_draw_list list = {0};
    stp_view view = {.eye = {0, 0, 20},
                     .up = {0, 1, 0},
                     .fov_degrees = 40,
                     .near_distance = 0.1,
                     .width = 128,
                     .height = 64,
                     .eye_distance = 0.5};
    float wall[64 * 64], air[64 * 64];
    for (int i = 0; i < 64 * 64; ++i) {
        wall[i] = 0.1f / 10.0f; // ten units away
        air[i] = 0.0f;
    }
    for (int walls = 0; walls < 4; ++walls) {
        stp_depth_pyramid pyramids[STP_EYES_MAX] = {{.level_count = 0}};
        for (uint32_t i = 0; i < 2; ++i) {
            stp_view one = stp_view_of_eye(&view, i);
            CHECK_EQUAL(STP_OK, make_pyramid(context, &one, (walls >> i & 1) != 0 ? wall : air,
                                             &pyramids[i]));
        }
        stp_quality quality = {.splat_size = 1, .occlusion = pyramids};
        CHECK_EQUAL(STP_OK, stp_select(context, store, &view, &quality, &list));
        CHECK_EQUAL(walls == 3, list.hidden_count);
        CHECK_EQUAL(walls != 3, list.count);
        for (uint32_t i = 0; i < 2; ++i) {
            stp_depth_pyramid_destroy(context, &pyramids[i]);
        }
    }
    stp_draw_list_destroy(context, &list);
    made_free_set(context, &scene.sets[0]);
    stp_store_close(store);
    stp_context_destroy(context);
}
