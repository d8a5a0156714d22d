// SPDX-License-Identifier: MIT
// Mesh simplification as a decimator (lab/decimate/mesh_decimator.c).
#include "decimate_helpers.h"

static decimate_model model;

/// Whether all vertices are used, and lie near the torus.
static bool is_sound_mesh(const stp_decimate_output* out, float tolerance)
{
    static uint8_t used[DECIMATE_POINTS];
    memset(used, 0, sizeof(used));
    for (uint32_t i = 0; i < 3 * out->triangle_count; ++i) {
        if (out->triangles[i] >= out->vertex_count) {
            return false;
        }
        used[out->triangles[i]] = 1;
    }
    bool good = true;
    for (uint32_t i = 0; i < out->vertex_count && good; ++i) {
        const float* p = out->vertices + 3 * (size_t)i;
        float around = sqrtf(p[0] * p[0] + p[2] * p[2]) - 1.0f;
        good = used[i] != 0 && fabsf(sqrtf(around * around + p[1] * p[1]) - 0.4f) < tolerance;
    }
    return good;
}

void test_decimate_mesh_reaches_vertices(test_state* test)
{
    stp_decimate_input input = decimate_torus(&model);
    stp_context* context = test_context(NULL, 2, NULL);
    static const uint32_t targets[] = {60, 333, 1000, DECIMATE_POINTS, 5000};
    for (size_t t = 0; t < sizeof(targets) / sizeof(targets[0]); ++t) {
        stp_decimate_output out;
        CHECK_EQUAL(STP_OK, stp_decimate_by_mesh(context, &input, targets[t], &out));
        CHECK_EQUAL(0, out.count);
        uint32_t wanted = targets[t] < DECIMATE_POINTS ? targets[t] : DECIMATE_POINTS;
        CHECK(out.vertex_count <= wanted && out.vertex_count + 2 >= wanted);
        CHECK(out.triangle_count >= 2 * out.vertex_count - 4);
        CHECK(is_sound_mesh(&out, targets[t] < 100 ? 0.1f : 0.02f));
        stp_decimate_output_destroy(context, &out);
    }
    stp_context_destroy(context);
}

// Triangles without shared vertices are welded first: otherwise no edge could collapse.
void test_decimate_mesh_welds_vertices(test_state* test)
{
    static float positions[18 * DECIMATE_POINTS];
    static uint32_t triangles[6 * DECIMATE_POINTS];
    stp_decimate_input input = decimate_torus(&model);
    for (uint32_t i = 0; i < 6 * DECIMATE_POINTS; ++i) {
        memcpy(positions + 3 * i, model.positions + 3 * model.triangles[i], 3 * sizeof(float));
        triangles[i] = i;
    }
    stp_decimate_input loose = {.count = 6 * DECIMATE_POINTS,
                                .positions = positions,
                                .triangles = triangles,
                                .triangle_count = 2 * DECIMATE_POINTS};
    stp_context* context = test_context(NULL, 1, NULL);
    stp_decimate_output out;
    CHECK_EQUAL(STP_OK, stp_decimate_by_mesh(context, &loose, 200, &out));
    CHECK_EQUAL(200, out.vertex_count);
    CHECK_EQUAL(400, out.triangle_count); // still a torus
    stp_decimate_output_destroy(context, &out);
    // and degenerate triangles at a corner are left out
    for (uint32_t i = 0; i < 3 * DECIMATE_POINTS; ++i) {
        model.triangles[i] = 7;
    }
    CHECK_EQUAL(STP_OK, stp_decimate_by_mesh(context, &input, 5000, &out));
    CHECK_EQUAL(DECIMATE_POINTS, out.triangle_count);
    stp_decimate_output_destroy(context, &out);
    stp_context_destroy(context);
}

void test_decimate_mesh_needs_triangles(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_decimate_input input = decimate_torus(&model);
    input.triangles = NULL;
    stp_decimate_output out;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, stp_decimate_by_mesh(context, &input, 10, &out));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "triangles") != NULL && out.vertices == NULL);
    stp_decimate_output_destroy(context, &out);
    input.triangles = model.triangles;
    input.triangle_count = 0;
    CHECK_EQUAL(STP_OK, stp_decimate_by_mesh(context, &input, 10, &out));
    CHECK(out.vertices != NULL && out.vertex_count == 0 && out.triangle_count == 0);
    stp_decimate_output_destroy(context, &out);
    stp_context_destroy(context);
}

void test_decimate_mesh_survives_failing_allocator(test_state* test)
{
    stp_decimate_input input = decimate_torus(&model);
    bool made = false;
    for (int n = 1; !made && n < 60; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context != NULL) {
            stp_decimate_output out;
            stp_result result = stp_decimate_by_mesh(context, &input, 500, &out);
            made = result == STP_OK && heap.count <= n;
            stp_decimate_output_destroy(context, &out);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
