// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/rng.h"
#include "lab/measure/hausdorff.h"

#include <math.h>
#include <string.h>

enum { SIDE = 21, VERTICES = SIDE * SIDE, TRIANGLES = 2 * (SIDE - 1) * (SIDE - 1) };

static float positions[3 * VERTICES];
static uint32_t indices[3 * TRIANGLES];

// A square of unit area in the plane z = 0, of triangles of different sizes.
static stp_measured_surface make_square(void)
{
    for (uint32_t i = 0; i < VERTICES; ++i) {
        double x = (double)(i % SIDE) / (SIDE - 1), y = (double)(i / SIDE) / (SIDE - 1);
        positions[3 * i] = (float)(x * x);
        positions[3 * i + 1] = (float)y;
        positions[3 * i + 2] = 0.0f;
    }
    uint32_t* at = indices;
    for (uint32_t y = 0; y + 1 < SIDE; ++y) {
        for (uint32_t x = 0; x + 1 < SIDE; ++x) {
            uint32_t a = y * SIDE + x, b = a + 1, c = a + SIDE, d = c + 1;
            const uint32_t corners[6] = {a, b, d, a, d, c};
            memcpy(at, corners, sizeof(corners));
            at += 6;
        }
    }
    return (stp_measured_surface){.positions = positions,
                                  .vertex_count = VERTICES,
                                  .indices = indices,
                                  .triangle_count = TRIANGLES};
}

static bool measure(stp_context* context, const stp_measured_surface* surface,
                    const stp_shapes* shapes, uint64_t samples, stp_hausdorff* found)
{
    stp_shape_tree tree;
    if (stp_shape_tree_create(context, shapes, &tree) != STP_OK) {
        return false;
    }
    stp_result result = stp_hausdorff_measure(context, surface, &tree, samples, found);
    stp_shape_tree_destroy(context, &tree);
    return result == STP_OK;
}

void test_hausdorff_of_a_square_and_a_disk(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_measured_surface square = make_square();
    stp_hausdorff found;
    // a disk that covers it, at height 0.25
    stp_disk_shape disk = {{0.5f, 0.5f, 0.25f}, {1, 0, 0}, {0, 1, 0}};
    stp_shapes shapes = {.disks = &disk, .disk_count = 1};
    CHECK(measure(context, &square, &shapes, 10000, &found));
    CHECK(fabs(found.max - 0.25) < 1e-12 && fabs(found.mean - 0.25) < 1e-12);
    CHECK(found.bound >= 0.25 && found.bound < 0.2503); // one disk is nearest to all of it
    CHECK(fabs(found.area - 1.0) < 1e-6);
    CHECK_EQUAL(10000, found.samples);
    CHECK(fabs(stp_shapes_area(&shapes) - STP_PI) < 1e-12);
    // a point in the corner: the mean distance in a unit square is (sqrt(2) + ln(1 + sqrt(2))) / 3,
    // the largest sqrt(2)
    disk = (stp_disk_shape){{0, 0, 0}, {0, 0, 0}, {0, 0, 0}};
    CHECK(measure(context, &square, &shapes, 100000, &found));
    CHECK(fabs(found.max - sqrt(2.0)) < 1e-12);
    CHECK(found.farthest.x == 1.0 && found.farthest.y == 1.0);
    CHECK(fabs(found.mean - (sqrt(2.0) + log(1.0 + sqrt(2.0))) / 3.0) < 1e-4);
    // an edge: the mean distance is a half, for any triangulation
    disk = (stp_disk_shape){{0.5f, 0, 0}, {0.5f, 0, 0}, {0, 0, 0}};
    CHECK(measure(context, &square, &shapes, 100000, &found));
    CHECK(fabs(found.max - 1.0) < 1e-12 && fabs(found.mean - 0.5) < 1e-4);
    disk = (stp_disk_shape){{0, 0.5f, 0}, {0, 0.5f, 0}, {0, 0, 0}};
    CHECK(measure(context, &square, &shapes, 100000, &found));
    CHECK(fabs(found.max - 1.0) < 1e-12 && fabs(found.mean - 0.5) < 1e-4);
    stp_context_destroy(context);
}

void test_hausdorff_of_a_surface_and_itself(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_measured_surface square = make_square();
    stp_shapes shapes = {.positions = positions, .indices = indices, .triangle_count = TRIANGLES};
    stp_hausdorff found;
    CHECK(measure(context, &square, &shapes, 20000, &found));
    CHECK(found.max < 1e-12 && found.mean < 1e-12 && found.bound < 1e-5);
    CHECK(fabs(stp_shapes_area(&shapes) - found.area) < 1e-12);
    // without one of its triangles, the distance is at most the radius of that triangle's inscribed
    // circle
    indices[0] = indices[1];
    shapes.triangle_count -= 1;
    shapes.indices += 3;
    square = make_square();
    CHECK(measure(context, &square, &shapes, 20000, &found));
    CHECK(found.max > 0.0 && found.max < 0.05);
    stp_context_destroy(context);
}

// The place farthest from the corners of a triangle lies between them: the centre of the
// circumscribed circle.
void test_hausdorff_finds_the_farthest_between_samples(test_state* test)
{
    static const float corners[] = {0, 0, 0, 1, 0, 0, 0.5f, 0.9f, 0};
    static const uint32_t triangle[] = {0, 1, 2};
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_disk_shape points[3] = {0};
    for (int k = 0; k < 3; ++k) {
        points[k].center = (stp_vec3){corners[3 * k], corners[3 * k + 1], 0};
    }
    stp_shapes shapes = {.disks = points, .disk_count = 3};
    stp_measured_surface surface = {
        .positions = corners, .vertex_count = 3, .indices = triangle, .triangle_count = 1};
    double height = (double)corners[7], radius = (0.25 + height * height) / (2.0 * height);
    stp_hausdorff found;
    CHECK(measure(context, &surface, &shapes, 0, &found));
    CHECK(found.max <= radius + 1e-12 && found.max > 0.9989 * radius);
    CHECK(found.bound >= radius && found.bound < 1.0011 * found.max);
    CHECK(fabs(found.farthest.x - 0.5) < 0.01 && fabs(found.farthest.y - (height - radius)) < 0.01);
    stp_context_destroy(context);
}

void test_hausdorff_of_points_and_unused_vertices(test_state* test)
{
    static const float points[] = {0, 0, 1, 0, 0, 2, 0, 0, 6};
    stp_context* context = test_context(NULL, 3, NULL);
    CHECK(context != NULL);
    stp_disk_shape disk = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    stp_shapes shapes = {.disks = &disk, .disk_count = 1};
    stp_measured_surface cloud = {.points = points, .point_count = 3};
    stp_hausdorff found;
    CHECK(measure(context, &cloud, &shapes, 1000, &found));
    CHECK(found.max == 6.0 && found.bound == 6.0 && found.mean == 3.0 && found.area == 0.0);
    CHECK_EQUAL(3, found.samples);
    CHECK(found.farthest.z == 6.0);
    // triangles without area: only their vertices count
    static const uint32_t flat[] = {0, 1, 1};
    stp_measured_surface needle = {
        .positions = points, .vertex_count = 3, .indices = flat, .triangle_count = 1};
    CHECK(measure(context, &needle, &shapes, 1000, &found));
    CHECK(found.max == 2.0 && found.mean == 1.5);
    CHECK_EQUAL(2, found.samples);
    stp_context_destroy(context);
}

void test_hausdorff_needs_both_sides(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    stp_disk_shape disk = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    stp_shapes shapes = {.disks = &disk, .disk_count = 1}, no_shapes = {0};
    stp_measured_surface square = make_square(), nothing = {0};
    stp_hausdorff found;
    CHECK(!measure(context, &nothing, &shapes, 10, &found));
    CHECK(strstr(log.text, "surface to measure is empty") != NULL);
    CHECK(!measure(context, &square, &no_shapes, 10, &found));
    CHECK(strstr(log.text, "no splat") != NULL);
    CHECK_EQUAL(2, log.errors);
    stp_context_destroy(context);
}

void test_hausdorff_samples_are_limited(test_state* test)
{
    CHECK_EQUAL(200000, stp_hausdorff_samples(0));
    CHECK_EQUAL(200000, stp_hausdorff_samples(20000));
    CHECK_EQUAL(300000, stp_hausdorff_samples(30000));
    CHECK_EQUAL(4000000, stp_hausdorff_samples(SIZE_MAX));
}

static stp_disk_shape disks[500];

static stp_shapes make_disks(void)
{
    for (uint32_t i = 0; i < 500; ++i) {
        float x = (float)stp_rng_below(1, i, 1000) * 1e-3f;
        float y = (float)stp_rng_below(2, i, 1000) * 1e-3f;
        float z = (float)stp_rng_below(3, i, 1000) * 1e-4f;
        disks[i] = (stp_disk_shape){{x, y, z}, {0.02f, 0.0f, 0.01f}, {0.0f, 0.01f, 0.0f}};
    }
    return (stp_shapes){.disks = disks, .disk_count = 500};
}

// No random place is farther than the proven bound.
void test_hausdorff_bound_holds_everywhere(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    stp_shapes shapes = make_disks();
    stp_shape_tree tree;
    stp_measured_surface square = make_square();
    stp_hausdorff found;
    CHECK_EQUAL(STP_OK, stp_shape_tree_create(context, &shapes, &tree));
    CHECK_EQUAL(STP_OK, stp_hausdorff_measure(context, &square, &tree, 300, &found));
    CHECK(found.bound >= found.max && found.bound < 1.0011 * found.max + 1e-5);
    double farthest = 0.0;
    for (uint32_t i = 0; i < 20000; ++i) {
        stp_vec3d place = {(double)stp_rng_below(5, i, 1u << 30) * 0x1p-30,
                           (double)stp_rng_below(6, i, 1u << 30) * 0x1p-30, 0.0};
        farthest = fmax(farthest, stp_shape_tree_distance_squared(&tree, place, NULL));
    }
    CHECK(sqrt(farthest) <= found.bound && sqrt(farthest) > 0.9 * found.max);
    double at = stp_shape_tree_distance_squared(&tree, found.farthest, NULL);
    CHECK(fabs(sqrt(at) - found.max) < 1e-12);
    stp_shape_tree_destroy(context, &tree);
    stp_context_destroy(context);
}

void test_hausdorff_is_the_same_for_any_threads(test_state* test)
{
    stp_hausdorff found[3];
    memset(found, 0, sizeof(found));
    stp_measured_surface square = make_square();
    stp_shapes shapes = make_disks();
    for (uint32_t i = 0; i < 3; ++i) {
        stp_context* context = test_context(NULL, i + 1, NULL);
        CHECK(context != NULL && measure(context, &square, &shapes, 30000, &found[i]));
        stp_context_destroy(context);
    }
    for (uint32_t i = 1; i < 3; ++i) {
        CHECK(memcmp(&found[0].max, &found[i].max, sizeof(double)) == 0);
        CHECK(found[0].bound >= found[0].max && found[0].bound == found[i].bound);
        CHECK(memcmp(&found[0].mean, &found[i].mean, sizeof(double)) == 0);
        CHECK(memcmp(&found[0].farthest, &found[i].farthest, sizeof(stp_vec3d)) == 0);
    }
}

void test_hausdorff_survives_failing_allocator(test_state* test)
{
    stp_measured_surface square = make_square();
    stp_shapes shapes = make_disks();
    bool made = false;
    for (int n = 1; !made && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_hausdorff found;
        if (context != NULL) {
            made = measure(context, &square, &shapes, 100, &found) && heap.count <= n;
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
