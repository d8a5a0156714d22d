// SPDX-License-Identifier: MIT
// Probabilities of disks that extend beyond thin or small content; other disks have no holes.
#include "candidate_helpers.h"
#include "tests.h"

#include "lod/blue/blue.h"

// Expected area of an octave's disks if none hides another: the sum of area times probability.
static double drawn_of(const maker* m, const stp_splats* s, uint32_t octave,
                       bool (*counts)(stp_vec3 normal))
{
    uint32_t end = s->octave_ends[octave];
    float reach = end < m->count ? m->radii[end] : m->final_radius;
    double radius = (double)(reach + s->candidate_radius), sum = 0.0;
    for (uint32_t i = 0; i < end; ++i) {
        const float* n = m->candidates.normals + 3 * (size_t)m->order[i];
        if (counts((stp_vec3){n[0], n[1], n[2]})) {
            sum += (double)stp_coverage_area(s->coverages[octave_start(s, octave) + i]) * STP_PI *
                   radius * radius;
        }
    }
    return sum;
}

static float reach_of(const maker* m, const stp_splats* s, uint32_t octave)
{
    uint32_t end = s->octave_ends[octave];
    return end < m->count ? m->radii[end] : m->final_radius;
}

static bool always(stp_vec3 normal)
{
    (void)normal;
    return true;
}

static bool is_upright(stp_vec3 normal)
{
    return fabsf(normal.z) < 0.5f;
}

static uint32_t paint_bars(double x, double y, void* user)
{
    (void)user;
    return fmod(x + 100.0, 0.1) < 0.016 || fmod(y + 100.0, 0.25) < 0.016 ? 0x808080ff : 0;
}

// Crossing bars, seen from both sides. Rays from either side meet the disks of both, so together
// they draw twice half of the area: the true area.
void test_lattices_keep_their_area(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.01);
    maker_add_plane(m, 1.0, paint_bars, NULL);
    uint32_t front = m->candidates.count;
    CHECK(context != NULL && 2 * front < MAKER_LIMIT);
    for (uint32_t i = 0; i < front; ++i) {
        const float* p = m->candidates.positions + 3 * (size_t)i;
        maker_add(m, (stp_vec3){p[0], p[1], -0.016f}, (stp_vec3){0, 0, -1}, 0x808080ff);
    }
    stp_splats s;
    CHECK_EQUAL(STP_OK,
                maker_finish(m, context,
                             m->candidates.count / 5 < 6000 ? m->candidates.count / 5 : 6000, &s));
    double truth = 4.0 * (1.0 - (1.0 - 0.16) * (1.0 - 0.064));
    int seen = 0;
    for (uint32_t octave = 0; octave + 1 < s.octave_count; ++octave) {
        float reach = reach_of(m, &s, octave);
        if (reach > 0.1f && reach < 0.4f) {
            double ratio = drawn_of(m, &s, octave, always) / truth;
            if (getenv("STP_TEST_PRINT") != NULL) {
                printf("octave %u: %u surfels, reach %.3f, ratio %.3f\n", octave,
                       s.octave_ends[octave], (double)reach, ratio);
            }
            CHECK(ratio > 0.7 && ratio < 1.8);
            ++seen;
        }
    }
    CHECK(seen >= 2);
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

static uint32_t paint_ground(double x, double y, void* user)
{
    (void)x, (void)y, (void)user;
    return 0x336633ff;
}

// The four sides of an upright pole, two candidates per square pixel.
static void add_pole(maker* m, double width, double height)
{
    double step = m->candidates.pixel_size / sqrt(2.0);
    for (int side = 0; side < 4; ++side) {
        double nx = side == 0 ? 1.0 : side == 1 ? -1.0 : 0.0;
        double ny = side == 2 ? 1.0 : side == 3 ? -1.0 : 0.0;
        for (double z = 0.5 * step; z < height; z += step) {
            for (double t = -0.5 * width + 0.5 * step; t < 0.5 * width; t += step) {
                stp_vec3 p = {(float)(nx * 0.5 * width + ny * t),
                              (float)(ny * 0.5 * width + nx * t), (float)z};
                maker_add(m, p, (stp_vec3){(float)nx, (float)ny, 0}, 0x402010ff);
            }
        }
    }
}

void test_poles_stay_small_and_their_ground_whole(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.02);
    maker_add_plane(m, 1.0, paint_ground, NULL);
    double width = 0.03, height = 0.35;
    add_pole(m, width, height);
    CHECK(context != NULL && m->candidates.count < MAKER_LIMIT);
    stp_splats s;
    CHECK_EQUAL(STP_OK, maker_finish(m, context, m->candidates.count / 9, &s));
    double half = 0.5 * 4.0 * width * height; // rays meet the disks of both sides
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        float reach = reach_of(m, &s, octave);
        if (reach > 0.4f) {
            continue;
        }
        double drawn = drawn_of(m, &s, octave, is_upright);
        if (getenv("STP_TEST_PRINT") != NULL) {
            printf("octave %u: %u surfels, reach %.3f, pole %.4f of %.4f\n", octave,
                   s.octave_ends[octave], (double)reach, drawn, half);
        }
        CHECK(reach < 0.08f || drawn < 2.0 * half);
        for (uint32_t i = 0; i < s.octave_ends[octave]; ++i) {
            const float* n = m->candidates.normals + 3 * (size_t)m->order[i];
            CHECK(n[2] < 0.5f || is_without_holes(s.coverages[octave_start(&s, octave) + i]));
        }
    }
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}

void test_boxes_are_whole_at_edges_and_corners(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    maker* m = maker_create(0.03);
    double step = m->candidates.pixel_size / sqrt(2.0);
    for (int face = 0; face < 6; ++face) {
        int axis = face / 2;
        float side = face % 2 == 0 ? 1.0f : -1.0f;
        for (double u = -1.0 + 0.5 * step; u < 1.0; u += step) {
            for (double v = -1.0 + 0.5 * step; v < 1.0; v += step) {
                float p[3], n[3] = {0, 0, 0};
                p[axis] = n[axis] = side;
                p[(axis + 1) % 3] = (float)u;
                p[(axis + 2) % 3] = (float)v;
                maker_add(m, (stp_vec3){p[0], p[1], p[2]}, (stp_vec3){n[0], n[1], n[2]},
                          0x808080ff);
            }
        }
    }
    stp_splats s;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK, maker_finish(m, context, 3000, &s));
    CHECK_EQUAL(3000, s.count);
    for (uint32_t octave = 0; octave < s.octave_count; ++octave) {
        uint32_t lower = 0;
        for (uint32_t i = 0; reach_of(m, &s, octave) < 0.4f && i < s.octave_ends[octave]; ++i) {
            lower += !is_without_holes(s.coverages[octave_start(&s, octave) + i]);
        }
        // a surfel of the finest octave, squeezed into a corner: disks of others cover its place
        CHECK(lower <= (octave + 1 < s.octave_count ? 0u : 2u));
    }
    stp_splats_destroy(context, &s);
    maker_destroy(m);
    stp_context_destroy(context);
}
