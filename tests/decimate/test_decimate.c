// SPDX-License-Identifier: MIT
// Properties of all decimators (lab/decimate).
#include "decimate_helpers.h"

static decimate_model model;

typedef struct decimator {
    stp_decimate_function run;
    bool covers;     ///< all points
    uint32_t behind; ///< tolerated shortfall of splats
} decimator;

static const decimator decimators[] = {{stp_decimate_by_octree, true, 6},
                                       {stp_decimate_by_octree_level, true, UINT32_MAX},
                                       {stp_decimate_by_quadric, false, 0},
                                       {stp_decimate_by_blue, true, 0}};
enum { DECIMATORS = sizeof(decimators) / sizeof(decimators[0]) };

void test_decimators_stand_for_a_torus(test_state* test)
{
    static const uint32_t targets[] = {60, 333, 1000, DECIMATE_POINTS, 5000};
    stp_decimate_input input = decimate_torus(&model);
    stp_context* context = test_context(NULL, 2, NULL);
    for (int d = 0; d < DECIMATORS; ++d) {
        for (size_t t = 0; t < sizeof(targets) / sizeof(targets[0]); ++t) {
            uint32_t maximum = targets[t] < DECIMATE_POINTS ? targets[t] : DECIMATE_POINTS;
            stp_decimate_output out;
            CHECK_EQUAL(STP_OK, decimators[d].run(context, &input, targets[t], &out));
            if (decimators[d].behind != UINT32_MAX) {
                CHECK(out.count <= maximum && out.count + decimators[d].behind >= maximum);
            }
            double area = 0.0, red = 0.0;
            for (uint32_t i = 0; i < out.count; ++i) {
                const stp_ellipse* e = &out.ellipses[i];
                float around = sqrtf(e->center.x * e->center.x + e->center.z * e->center.z);
                float away = sqrtf((around - 1.0f) * (around - 1.0f) + e->center.y * e->center.y);
                CHECK(decimate_is_sound(e) && away > 0.15f && away < 0.5f);
                // it faces away from the ring
                stp_vec3 ring = {e->center.x / around, 0.0f, e->center.z / around};
                CHECK(out.count < 300 ||
                      stp_dot(e->normal, stp_sub(e->center, ring)) > 0.5f * away);
                double own = (double)stp_ellipse_area(e);
                area += own;
                red += own * (double)out.colors[3 * i] / 255.0;
                CHECK_EQUAL(0, out.colors[3 * i + 2]);
            }
            double ratio = area / (4.0 * STP_PI * STP_PI * 0.4);
            CHECK(ratio > 1.0 && ratio < 12.0);
            CHECK(red > 0.3 * area && red < 0.8 * area);
            // quadric splats hold no list of points: nearly all are covered
            uint32_t bare = decimate_count_bare(&input, &out, 0.4f);
            CHECK(bare <= (decimators[d].covers ? 0u : DECIMATE_POINTS / 50));
            stp_decimate_output_destroy(context, &out);
        }
    }
    stp_context_destroy(context);
}

void test_decimators_do_not_depend_on_threads(test_state* test)
{
    stp_decimate_input input = decimate_torus(&model);
    for (int known = 0; known < 2; ++known) {
        input.normals = known != 0 ? model.normals : NULL;
        for (int d = 0; d < DECIMATORS; ++d) {
            stp_decimate_output outs[3];
            stp_context* contexts[3];
            for (uint32_t i = 0; i < 3; ++i) {
                contexts[i] = test_context(NULL, i + 1, NULL);
                CHECK_EQUAL(STP_OK, decimators[d].run(contexts[i], &input, 300, &outs[i]));
                CHECK_EQUAL(outs[0].count, outs[i].count);
                CHECK(memcmp(outs[0].ellipses, outs[i].ellipses,
                             outs[0].count * sizeof(stp_ellipse)) == 0);
                CHECK(memcmp(outs[0].colors, outs[i].colors, 3 * (size_t)outs[0].count) == 0);
            }
            for (uint32_t i = 0; i < 3; ++i) {
                stp_decimate_output_destroy(contexts[i], &outs[i]);
                stp_context_destroy(contexts[i]);
            }
        }
    }
}

// Points of some shape: at one place, on a line, on a parabola, at a few places, on a coarse grid.
// Some have no known normal.
static void place_points(uint32_t shape, uint32_t count, float scale)
{
    for (uint32_t i = 0; i < count; ++i) {
        const float at[5][3] = {{5.0f, 0.0f, 1.0f},
                                {(float)i, 0.0f, 1.0f},
                                {(float)i, (float)(i * i % 17), 1.0f},
                                {(float)(i % 3), 0.0f, -0.0f * (float)(i % 2)},
                                {(float)(i % 10), (float)(i / 10 % 10), (float)(i / 100)}};
        for (uint32_t k = 0; k < 3; ++k) {
            model.positions[3 * i + k] = scale * at[shape][k];
            model.normals[3 * i + k] = k == 1 && i % 4 != 0 ? (i % 2 == 0 ? 1.0f : -1.0f) : 0.0f;
        }
    }
}

void test_decimators_take_any_points(test_state* test)
{
    static const uint32_t counts[] = {0, 1, 2, 3, 100, 700};
    static const float scales[] = {1.0f, 1e-15f, 1e15f};
    stp_context* context = test_context(NULL, 2, NULL);
    for (uint32_t run = 0; run < 5 * 6 * 3 * 2 * 2; ++run) {
        uint32_t shape = run % 5, count = counts[run / 5 % 6];
        place_points(shape, count, scales[run / 30 % 3]);
        stp_decimate_input input = {.count = count, .positions = model.positions};
        input.normals = run / 90 % 2 == 0 ? model.normals : NULL;
        for (int d = 0; d < DECIMATORS; ++d) {
            uint32_t target = run / 180 == 0 ? 1 : 20;
            stp_decimate_output out;
            CHECK_EQUAL(STP_OK, decimators[d].run(context, &input, target, &out));
            CHECK(out.count <= count && (count == 0) == (out.count == 0));
            for (uint32_t i = 0; i < out.count; ++i) {
                CHECK(decimate_is_sound(&out.ellipses[i]));
                CHECK_EQUAL(255, out.colors[3 * i + 1]);
            }
            if (decimators[d].covers) {
                CHECK_EQUAL(0, decimate_count_bare(&input, &out, HUGE_VALF));
            }
            stp_decimate_output_destroy(context, &out);
        }
    }
    stp_context_destroy(context);
}

// Points at the same place give one splat.
void test_decimators_merge_coincident_points(test_state* test)
{
    place_points(3, 300, 1.0f);
    stp_decimate_input input = {.count = 300, .positions = model.positions};
    stp_context* context = test_context(NULL, 1, NULL);
    for (int d = 0; d < DECIMATORS; ++d) {
        stp_decimate_output out;
        CHECK_EQUAL(STP_OK, decimators[d].run(context, &input, 100, &out));
        CHECK_EQUAL(3, out.count);
        stp_decimate_output_destroy(context, &out);
    }
    stp_context_destroy(context);
}

void test_decimators_refuse_too_many_points(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    stp_decimate_input input = {.count = UINT32_MAX, .positions = model.positions};
    for (int d = 0; d < DECIMATORS; ++d) {
        stp_decimate_output out;
        CHECK_EQUAL(STP_ERROR_LIMIT, decimators[d].run(context, &input, 1, &out));
        CHECK_EQUAL(d + 1, log.errors);
        stp_decimate_output_destroy(context, &out);
    }
    stp_context_destroy(context);
}

void test_decimators_survive_failing_allocator(test_state* test)
{
    stp_decimate_input input = decimate_torus(&model);
    input.count = 300;
    for (int d = 0; d < DECIMATORS; ++d) {
        bool made = false;
        for (int n = 1; !made && n < 200; ++n) {
            test_heap heap = TEST_HEAP(n);
            stp_context* context = test_context(&heap, 1, NULL);
            if (context != NULL) {
                stp_decimate_output out;
                stp_result result = decimators[d].run(context, &input, 10, &out);
                made = result == STP_OK && heap.count <= n;
                stp_decimate_output_destroy(context, &out);
            }
            stp_context_destroy(context);
            CHECK_EQUAL(0, heap.live_bytes);
        }
        CHECK(made);
    }
}
