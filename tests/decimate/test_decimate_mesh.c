// SPDX-License-Identifier: MIT
// Mesh simplification as a decimator (lab/decimate/mesh_decimator.c).
#include "decimate_helpers.h"

static decimate_model model;

static bool is_sound_mesh(const stp_decimate_output* out)
{
    static uint8_t used[DECIMATE_POINTS];
    memset(used, 0, sizeof(used));
    for (uint32_t i = 0; i < 3 * out->triangle_count; ++i) {
        if (out->triangles[i] >= out->vertex_count) {
            return false;
        }
        used[out->triangles[i]] = 1;
    }
    for (uint32_t i = 0; i < out->vertex_count;
         ++i) { // all are used, and are vertices of the input
        const float* p = out->vertices + 3 * (size_t)i;
        bool found = false;
        for (uint32_t v = 0; v < DECIMATE_POINTS && !found; ++v) {
            found = memcmp(p, model.positions + 3 * v, 3 * sizeof(*p)) == 0 &&
                    memcmp(out->colors + 3 * (size_t)i, model.colors + 3 * v, 3) == 0;
        }
        if (!found || used[i] == 0) {
            return false;
        }
    }
    return true;
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
        CHECK_EQUAL(targets[t] < DECIMATE_POINTS ? targets[t] : DECIMATE_POINTS, out.vertex_count);
        CHECK_EQUAL(2 * out.vertex_count, out.triangle_count); // still a torus
        CHECK(is_sound_mesh(&out));
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
    CHECK_EQUAL(400, out.triangle_count);
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
    // the simplifier's memory is counted too
    stp_context* context = NULL;
    test_log log = {0};
    stp_context_desc desc = {.thread_count = 1,
                             .memory_limit_bytes = 600 << 10,
                             .log = test_log_message,
                             .log_user = &log};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    stp_decimate_output out;
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_decimate_by_mesh(context, &input, 500, &out));
    CHECK_EQUAL(1, log.errors);
    stp_decimate_output_destroy(context, &out);
    stp_context_destroy(context);
}
