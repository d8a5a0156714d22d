// SPDX-License-Identifier: MIT
#include "hierarchy_helpers.h"
#include "tests.h"

#include "base/io/hash.h"
#include "base/splats/coverage.h"
#include "lod/blue/children.h"

// A row of spheres over a plate of triangles that has no set of its own: sets and triangles in one
// picture.
static bool make_mixed(stp_context* context, hierarchy* h, uint32_t* root)
{
    enum { COUNT = 6 };
    stp_affine copies[COUNT];
    for (int i = 0; i < COUNT; ++i) {
        copies[i] = scale_and_move(i % 2 == 0 ? 1 : -1, 1, 1 + 0.1 * i, 2.2 * i, 1.2, 0);
    }
    uint32_t mesh;
    return hierarchy_begin(context, h, true, 5) &&
           add_copies(h, h->shape, copies, COUNT, false, root) &&
           add_grid(h->scene, 4, 2, false, 0, &mesh) &&
           stp_scene_add_object(
               h->scene,
               &(stp_object){.parent = *root, .transform = scale_and_move(8, 0.1, 3, 5, -1, 0)},
               NULL) == STP_OK &&
           stp_scene_add_part(h->scene, (stp_part){STP_PART_MESH, mesh}) == STP_OK &&
           hierarchy_finish(h);
}

static stp_result build_mixed(stp_context* context, hierarchy* h, uint32_t* node)
{
    uint32_t root;
    if (!make_mixed(context, h, &root)) {
        return STP_ERROR_OUT_OF_MEMORY;
    }
    *node = h->scene->objects[root].node;
    stp_result result = hierarchy_make(h, h->scene->objects[h->shape].node, 300, 2000, NULL);
    return result == STP_OK ? hierarchy_make(h, *node, 150, 1200, NULL) : result;
}

static stp_hash hash_surfels(const stp_splats* s)
{
    size_t entries = 0;
    for (uint32_t i = 0; i < s->octave_count; ++i) {
        entries += s->octave_ends[i];
    }
    stp_hash a = stp_hash_bytes((stp_hash){0}, s->positions, 6 * (size_t)s->count);
    a = stp_hash_bytes(a, s->normals, 2 * (size_t)s->count);
    a = stp_hash_bytes(a, s->colors, 3 * entries);
    return stp_hash_bytes(a, s->coverages, entries);
}

void test_mixed_nodes_take_sets_and_triangles(test_state* test)
{
    uint64_t first = 0;
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        hierarchy h;
        uint32_t node;
        CHECK(context != NULL);
        CHECK_EQUAL(STP_OK, build_mixed(context, &h, &node));
        const stp_splats* s = &h.made[node];
        uint32_t on_plate = 0;
        for (uint32_t i = 0; i < s->count; ++i) {
            double y = (double)s->origin.y + (double)s->step * s->positions[3 * i + 1];
            on_plate += y < -0.85;
        }
        CHECK_EQUAL(150, s->count);
        CHECK(on_plate > 20 && on_plate < 120);
        stp_hash hash = hash_surfels(s);
        first = threads == 1 ? hash.low : first;
        CHECK_EQUAL(first, hash.low);
        hierarchy_destroy(&h);
        stp_context_destroy(context);
    }
}

void test_hierarchy_survives_failing_allocator(test_state* test)
{
    for (int n = 0;; n += 1 + n / 32) { // each of the first, then some
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context == NULL) {
            CHECK_EQUAL(0, heap.live_bytes);
            continue;
        }
        hierarchy h;
        uint32_t node;
        stp_result result = build_mixed(context, &h, &node);
        hierarchy_destroy(&h);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
        if (result == STP_OK) {
            CHECK(n > 100);
            return;
        }
    }
}

// A node over point clouds is captured from their surfels; a node that holds the points itself
// keeps them all.
void test_points_below_a_node(test_state* test)
{
    enum { POINTS = 4000 };
    stp_context* context = test_context(NULL, 2, NULL);
    hierarchy h = {0};
    CHECK(context != NULL && stp_scene_create(context, &h.scene) == STP_OK);
    stp_point_set points = {.point_count = POINTS};
    points.positions = STP_NEW_ARRAY(context, float, 3 * (size_t)POINTS);
    CHECK(points.positions != NULL);
    for (int i = 0; i < POINTS; ++i) {
        points.positions[3 * i] = (float)(i % 64) / 32.0f - 1.0f;
        points.positions[3 * i + 1] = 0.0f;
        points.positions[3 * i + 2] = (float)(i / 64) / 32.0f - 1.0f;
    }
    uint32_t set, root, other;
    stp_object object = {
        .parent = STP_NONE, .transform = stp_affine_identity(), .flags = STP_OBJECT_PROTOTYPE};
    CHECK_EQUAL(STP_OK, stp_scene_add_point_set(h.scene, &points, &set));
    CHECK_EQUAL(STP_OK, stp_scene_add_object(h.scene, &object, &h.shape));
    CHECK_EQUAL(STP_OK, stp_scene_add_part(h.scene, (stp_part){STP_PART_POINTS, set}));
    stp_affine copies[9];
    for (int i = 0; i < 9; ++i) {
        copies[i] = scale_and_move(1, 1, 1, 2.03 * (i % 3), 0, 2.03 * (i / 3));
    }
    CHECK(add_copies(&h, h.shape, copies, 9, false, &root) && hierarchy_finish(&h));
    other = h.scene->objects[h.shape].node;
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, other, 0, 0, NULL));
    CHECK_EQUAL(POINTS, h.made[other].count);
    uint32_t node = h.scene->objects[root].node;
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, node, 1000, 9000, NULL));
    const stp_splats* s = &h.made[node];
    CHECK_EQUAL(1000, s->count);
    uint32_t cells[9] = {0};
    for (uint32_t i = 0; i < s->count; ++i) {
        double x = (double)s->origin.x + (double)s->step * s->positions[3 * i];
        double z = (double)s->origin.z + (double)s->step * s->positions[3 * i + 2];
        int cell = (int)((x + 1.0) / 2.03) + 3 * (int)((z + 1.0) / 2.03);
        cells[cell < 0 || cell > 8 ? 0 : cell] += 1;
    }
    for (int i = 0; i < 9; ++i) {
        CHECK(cells[i] > 70 && cells[i] < 150);
    }
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}

// An upper node has the colours, materials and coverage of its content.
void test_appearance_goes_up(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    uint32_t root;
    stp_affine copies[9];
    for (int i = 0; i < 9; ++i) {
        copies[i] = scale_and_move(1, 1, 1, 2.1 * (i % 3), 2.1 * (i / 3), 0);
    }
    CHECK(context != NULL && hierarchy_begin(context, &h, true, 8));
    CHECK(add_copies(&h, h.shape, copies, 9, false, &root) && hierarchy_finish(&h));
    uint32_t child = h.scene->objects[h.shape].node, node = h.scene->objects[root].node;
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, child, 1000, 12000, NULL));
    stp_splats* below = &h.made[child];
    size_t entries = 0;
    for (uint32_t i = 0; i < below->octave_count; ++i) {
        entries += below->octave_ends[i];
    }
    for (size_t i = 0; i < entries; ++i) { // the content below has one colour and half coverage
        below->colors[3 * i] = 200;
        below->colors[3 * i + 1] = 100;
        below->colors[3 * i + 2] = 50;
        below->coverages[i] = stp_coverage_of_share(75.0 / 255.0); // 1 - (1 - 75/255)^2 = 0.5
    }
    for (uint32_t i = 0; i < below->count; ++i) {
        below->materials[i] = 7;
    }
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, node, 500, 4500, NULL));
    const stp_splats* s = &h.made[node];
    size_t last = 0;
    for (uint32_t i = 0; i + 1 < s->octave_count; ++i) {
        last += s->octave_ends[i];
    }
    uint32_t sum = 0;
    for (uint32_t i = 0; i < s->count; ++i) {
        CHECK_EQUAL(7, s->materials[i]);
        CHECK_EQUAL(200, s->colors[3 * (last + i)]);
        CHECK_EQUAL(100, s->colors[3 * (last + i) + 1]);
        CHECK_EQUAL(50, s->colors[3 * (last + i) + 2]);
        sum += stp_coverage_share(s->coverages[last + i]);
    }
    double mean = (double)sum / s->count;
    // shares have steps of an eighth; disks have no holes where layers of spheres hide the
    // background
    CHECK(mean > 68.0 && mean < 84.0);
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}

void test_what_is_smaller_than_floats_measure_gets_no_surfels(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    const double scales[] = {1e-44, 1e-42, 1e-38, 1e-30, 1e-19, 1e-15, 1e-6};
    for (int i = 0; i < 7; ++i) {
        hierarchy h;
        uint32_t root;
        stp_affine copy = scale_and_move(scales[i], scales[i], scales[i], 0, 0, 0);
        CHECK(context != NULL && hierarchy_begin(context, &h, true, 8));
        CHECK(add_copies(&h, h.shape, &copy, 1, false, &root) && hierarchy_finish(&h));
        uint32_t node = h.scene->objects[root].node;
        CHECK_EQUAL(STP_OK, hierarchy_make(&h, node, 500, 4500, NULL));
        CHECK(scales[i] < 1e-18 ? h.made[node].count == 0 : h.made[node].count > 400);
        hierarchy_destroy(&h);
    }
    stp_context_destroy(context);
}

void test_pictures_of_far_apart_sets_cost_what_is_there(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    hierarchy h;
    uint32_t root;
    stp_affine copies[2] = {stp_affine_identity(), scale_and_move(1, 1, 1, 1e6, 1e6, 3e5)};
    CHECK(context != NULL && hierarchy_begin(context, &h, true, 8));
    CHECK(add_copies(&h, h.shape, copies, 2, false, &root) && hierarchy_finish(&h));
    uint32_t child = h.scene->objects[h.shape].node, node = h.scene->objects[root].node;
    CHECK_EQUAL(STP_OK, hierarchy_make(&h, child, 500, 6000, NULL));
    stp_blue_desc desc = {.capture = {.wanted_candidates = 3000}, .sets = h.sets};
    stp_candidates c = {0};
    bool captured;
    CHECK_EQUAL(STP_OK, stp_capture_children(h.scene, node, &desc, 100, &c, &captured));
    double pixels = (double)c.resolution * (double)c.resolution * c.direction_count;
    CHECK(captured && pixels < 2.0 * STP_CAPTURE_MAX_PIXELS_EACH * 3000.0);
    stp_candidates_destroy(context, &c);
    hierarchy_destroy(&h);
    stp_context_destroy(context);
}
