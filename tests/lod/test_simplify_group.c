// SPDX-License-Identifier: MIT
// Simplified groups: colours of corners, and how much their look changed.
#include "tests.h"

#include "lod/levels/simplify_group.h"

#include <math.h>
#include <string.h>

enum { SIDE = 20, TRIANGLES = 2 * SIDE * SIDE, VERTICES = (SIDE + 1) * (SIDE + 1) };

static const stp_collapse_desc to_a_half = {.triangle_target = TRIANGLES / 2,
                                            .error_limit = 0.05,
                                            .border_weight = 0.3,
                                            .least_cosine = 0.2};

/// Colour of a corner at a place of the square, of a triangle.
typedef void corner_color(double x, double z, uint32_t triangle, float color[3]);

/// A square of width 1, with the vertices of its rim locked. Numbers of vertices begin at 100; tags
/// are 0 where x is below 0.5, else 1. `bump`: height of waves.
static stp_result make_square(stp_context* context, corner_color* color_of, double bump,
                              stp_group_mesh* group)
{
    stp_result result = stp_group_create(context, TRIANGLES, color_of != NULL, group);
    for (uint32_t t = 0; t < TRIANGLES && result == STP_OK; ++t) {
        uint32_t x = t / 2 % SIDE, z = t / 2 / SIDE, a = 100 + z * (SIDE + 1) + x;
        const uint32_t low[3] = {a, a + SIDE + 1, a + 1};
        const uint32_t high[3] = {a + 1, a + SIDE + 1, a + SIDE + 2};
        memcpy(group->indices + 3 * (size_t)t, t % 2 == 0 ? low : high, sizeof(low));
        group->tags[t] = x < SIDE / 2 ? 0 : 1;
        group->sides[t] = (uint8_t)(1 + group->tags[t]);
        group->spreads[2 * t] = group->spreads[2 * t + 1] = 0.0f;
    }
    group->keeps_tags = true;
    result = result == STP_OK ? stp_group_number(context, group) : result;
    for (uint32_t v = 0; v < group->vertex_count && result == STP_OK; ++v) {
        uint32_t number = group->vertices[v] - 100, x = number % (SIDE + 1);
        uint32_t z = number / (SIDE + 1);
        group->positions[3 * v] = (float)x / SIDE;
        group->positions[3 * v + 1] = (float)(bump * sin(2.1 * x) * cos(1.7 * z));
        group->positions[3 * v + 2] = (float)z / SIDE;
        group->locked[v] = x == 0 || z == 0 || x == SIDE || z == SIDE;
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES && result == STP_OK && color_of != NULL; ++i) {
        const float* p = group->positions + 3 * (size_t)group->indices[i];
        color_of((double)p[0], (double)p[2], i / 3, group->colors + 3 * (size_t)i);
    }
    return result;
}

static double area_of(const stp_group_mesh* group, uint32_t triangle)
{
    stp_vec3d p[3];
    for (size_t k = 0; k < 3; ++k) {
        const float* at = group->positions + 3 * (size_t)group->indices[3 * (size_t)triangle + k];
        p[k] = (stp_vec3d){(double)at[0], (double)at[1], (double)at[2]};
    }
    return 0.5 * stp_lengthd(stp_crossd(stp_subd(p[1], p[0]), stp_subd(p[2], p[0])));
}

static void two_colors(double x, double z, uint32_t triangle, float color[3])
{
    (void)x;
    (void)z;
    bool second = triangle / 2 % SIDE >= SIDE / 2;
    color[0] = second ? 0.25f : 0.75f;
    color[1] = 0.5f;
    color[2] = second ? 1.0f : 0.0f;
}

void test_group_numbers_its_vertices(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_group_mesh group;
    CHECK_EQUAL(STP_OK, make_square(context, NULL, 0.0, &group));
    CHECK(group.vertex_count == VERTICES && group.colors == NULL);
    for (uint32_t v = 0; v < VERTICES; ++v) {
        CHECK_EQUAL(100 + v, group.vertices[v]);
    }
    for (uint32_t i = 0; i < 3 * TRIANGLES; ++i) {
        CHECK(group.indices[i] < VERTICES);
    }
    stp_group_destroy(context, &group);
    stp_context_destroy(context);
}

void test_group_of_a_plane_keeps_its_look(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_group_mesh group;
    double error = -1.0, spreads[2], size, sum = 0.0, first = 0.0;
    CHECK_EQUAL(STP_OK, make_square(context, two_colors, 0.0, &group));
    float places[3 * VERTICES];
    memcpy(places, group.positions, sizeof(places));
    CHECK_EQUAL(STP_OK, stp_group_simplify(context, &to_a_half, &group, &error, spreads, &size));
    CHECK(group.triangle_count <= TRIANGLES / 2 && group.triangle_count > 4 * SIDE);
    CHECK(error >= 0.0 && error < 1e-6);
    CHECK(fabs(spreads[0]) < 1e-12 && fabs(spreads[1]) < 1e-12);
    bool used[VERTICES] = {false};
    for (uint32_t t = 0; t < group.triangle_count; ++t) {
        CHECK(group.tags[t] < 2 && group.sides[t] == 1 + group.tags[t]);
        CHECK(group.spreads[2 * t] == (float)spreads[0]);
        CHECK(group.spreads[2 * t + 1] == (float)spreads[1]);
        for (size_t k = 0; k < 3; ++k) { // corners of two colours may share a vertex
            const float* color = group.colors + 9 * (size_t)t + 3 * k;
            CHECK(fabsf(color[0] - (group.tags[t] == 0 ? 0.75f : 0.25f)) < 1e-6f);
            CHECK(fabsf(color[1] - 0.5f) < 1e-6f);
            CHECK(fabsf(color[2] - (float)group.tags[t]) < 1e-6f);
            used[group.indices[3 * (size_t)t + k]] = true;
        }
        sum += area_of(&group, t);
        first += group.tags[t] == 0 ? area_of(&group, t) : 0.0;
    }
    CHECK(fabs(sum - 1.0) < 1e-5);   // its rim is locked
    CHECK(fabs(first - 0.5) < 1e-5); // and the border of both colours is kept
    CHECK(fabs(size - sqrt(2.0 * sum / group.triangle_count)) < 1e-9);
    for (uint32_t v = 0; v < VERTICES; ++v) {
        bool same = memcmp(places + 3 * v, group.positions + 3 * v, 3 * sizeof(float)) == 0;
        CHECK_EQUAL(same ? 100 + v : UINT32_MAX, group.vertices[v]);
        CHECK(group.locked[v] == 0 || (same && used[v]));
    }
    stp_group_destroy(context, &group);
    stp_context_destroy(context);
}

static void grade(double x, double z, uint32_t triangle, float color[3])
{
    (void)triangle;
    color[0] = (float)x;
    color[1] = (float)(0.2 + 0.5 * z);
    color[2] = (float)(0.5 + 0.5 * sin(20.0 * x) * sin(20.0 * z));
}

void test_group_keeps_mean_colors_and_measures_their_change(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_group_mesh group;
    double error, spreads[2], size, mean[2][3] = {{0}};
    CHECK_EQUAL(STP_OK, make_square(context, grade, 0.0, &group));
    for (int round = 0; round < 2; ++round) {
        for (uint32_t t = 0; t < group.triangle_count; ++t) {
            for (size_t k = 0; k < 9; ++k) {
                mean[round][k % 3] +=
                    area_of(&group, t) / 3.0 * (double)group.colors[9 * (size_t)t + k];
            }
        }
        if (round == 0) {
            CHECK_EQUAL(STP_OK,
                        stp_group_simplify(context, &to_a_half, &group, &error, spreads, &size));
        }
    }
    for (int c = 0; c < 3; ++c) {
        CHECK(fabs(mean[0][c] - mean[1][c]) < 0.05);
    }
    CHECK(spreads[0] > 1e-4 && spreads[0] < 0.1 && fabs(spreads[1]) < 1e-12);
    stp_group_destroy(context, &group);
    stp_context_destroy(context);
}

void test_group_adds_to_spreads_of_its_triangles(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_group_mesh group;
    double error, spreads[2], size;
    CHECK_EQUAL(STP_OK, make_square(context, two_colors, 0.0, &group));
    for (uint32_t t = 0; t < TRIANGLES; ++t) { // all are of one area
        group.spreads[2 * t] = t % 2 == 0 ? 0.1f : 0.3f;
        group.spreads[2 * t + 1] = 0.5f;
    }
    CHECK_EQUAL(STP_OK, stp_group_simplify(context, &to_a_half, &group, &error, spreads, &size));
    CHECK(fabs(spreads[0] - 0.2) < 1e-6 && fabs(spreads[1] - 0.5) < 1e-6);
    stp_group_destroy(context, &group);
    // waves that are flattened turn normals
    CHECK_EQUAL(STP_OK, make_square(context, NULL, 0.01, &group));
    CHECK_EQUAL(STP_OK, stp_group_simplify(context, &to_a_half, &group, &error, spreads, &size));
    CHECK(error > 1e-4 && error < 0.02 && spreads[0] <= 0.0 && spreads[1] > 0.005 &&
          spreads[1] < 1.0);
    stp_group_destroy(context, &group);
    stp_context_destroy(context);
}

void test_group_survives_failing_allocator(test_state* test)
{
    bool made = false;
    for (int n = 1; !made && n < 200; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_group_mesh group;
            double error, spreads[2], size;
            stp_result result = make_square(context, grade, 0.0, &group);
            result = result == STP_OK
                         ? stp_group_simplify(context, &to_a_half, &group, &error, spreads, &size)
                         : result;
            made = result == STP_OK && heap.count <= n;
            CHECK(result == STP_OK || result == STP_ERROR_OUT_OF_MEMORY);
            stp_group_destroy(context, &group);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
