// SPDX-License-Identifier: MIT
// Normals of clouds without any: the plane through a point's neighbours, with the same bits on all processors.
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "lod/cloud_candidates.h"
#include "lod/point_normals_kernels.h"

#include <string.h>

enum { POINTS = 3000 };

static float random_float(uint64_t seed, uint32_t i)
{
    return (float)(stp_rng_hash(seed, i) >> 40) / 16777216.0f;
}

/// A wavy sheet whose true normals are known; with `crowd`, a quarter of the points are one.
static void make_sheet(float positions[3 * POINTS], float truth[3 * POINTS], bool crowd)
{
    for (uint32_t i = 0; i < POINTS; ++i) {
        uint32_t from = crowd && i < POINTS / 4 ? 0 : i;
        float x = 10.0f * random_float(1, from), z = 10.0f * random_float(2, from);
        stp_vec3 normal = stp_normalize((stp_vec3){-0.2f * x, 1.0f, 0.1f});
        const float p[3] = {x, 0.1f * x * x - 0.1f * z, z};
        memcpy(positions + 3 * (size_t)i, p, sizeof(p));
        memcpy(truth + 3 * (size_t)i, &normal, sizeof(normal));
    }
}

void test_point_normals_are_those_of_the_surface(test_state* test)
{
    static float positions[3 * POINTS], normals[3 * POINTS], truth[3 * POINTS];
    stp_context* context = test_context(NULL, 2, NULL);
    make_sheet(positions, truth, false);
    for (size_t i = 0; i < POINTS; ++i) {
        memcpy(normals + 3 * i, (const float[3]){0, 1, 0}, 3 * sizeof(float));
    }
    stp_candidates candidates = {.count = POINTS, .positions = positions, .normals = normals};
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &candidates, 0.8f));
    uint32_t good = 0;
    for (size_t i = 0; i < POINTS; ++i) {
        float cosine = 0.0f, length = 0.0f;
        for (size_t k = 0; k < 3; ++k) {
            cosine += normals[3 * i + k] * truth[3 * i + k];
            length += normals[3 * i + k] * normals[3 * i + k];
        }
        CHECK(fabsf(length - 1.0f) < 1e-5f);
        good += fabsf(cosine) > 0.98f ? 1 : 0;
    }
    CHECK(good > POINTS * 9 / 10); // neighbourhoods are lopsided at the border
    stp_context_destroy(context);
}

// Each maps a vector to one direction, along which the points vary no more than along others.
static void check_matrices(test_state* test, const float (*sums)[STP_NORMAL_SUMS],
                           float (*matrices)[STP_NORMAL_MATRIX])
{
    for (size_t i = 0; i < POINTS; ++i) {
        const float* m = matrices[i];
        if (!(m[0] + m[3] + m[5] > 1.0f - 1e-5f)) {
            continue; // all directions are alike, or two of them
        }
        double n[3] = {(double)m[1], (double)m[3], (double)m[4]}, v[3];
        if (n[1] < 0.3) {
            continue; // the column is nearly 0
        }
        double s[10], length = n[0] * n[0] + n[1] * n[1] + n[2] * n[2];
        for (int k = 0; k < 10; ++k) {
            s[k] = (double)sums[i][k] / (double)sums[i][0];
        }
        const double c[3][3] = {{s[4] - s[1] * s[1], s[5] - s[1] * s[2], s[6] - s[1] * s[3]},
                                {s[5] - s[1] * s[2], s[7] - s[2] * s[2], s[8] - s[2] * s[3]},
                                {s[6] - s[1] * s[3], s[8] - s[2] * s[3], s[9] - s[3] * s[3]}};
        double along = 0.0;
        for (int k = 0; k < 3; ++k) {
            v[k] = c[k][0] * n[0] + c[k][1] * n[1] + c[k][2] * n[2];
            along += v[k] * n[k] / length;
        }
        double trace = c[0][0] + c[1][1] + c[2][2];
        for (int k = 0; k < 3; ++k) { // an eigenvector, of no more than a third of the trace
            CHECK(fabs(v[k] - along * n[k]) <= 1e-4 * trace);
        }
        CHECK(along <= trace / 3.0 + 1e-6 * trace);
    }
}

/// Lists the points from `begin` on, and pads the list as kernels expect.
static void list_points(const float* positions, uint32_t begin, uint32_t count,
                        stp_near_points* list)
{
    for (list->count = 0; list->count < count || list->count % 8 != 0; ++list->count) {
        const float* p = positions + 3 * (size_t)(begin + list->count);
        bool real = list->count < count;
        list->x[list->count] = real ? p[0] : INFINITY;
        list->y[list->count] = real ? p[1] : INFINITY;
        list->z[list->count] = real ? p[2] : INFINITY;
    }
}

void test_point_normals_have_the_same_sums_everywhere(test_state* test)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    static float plain[POINTS][STP_NORMAL_SUMS], wide[POINTS][STP_NORMAL_SUMS];
    static float matrices[POINTS][STP_NORMAL_MATRIX], other[POINTS][STP_NORMAL_MATRIX];
    const float radii[] = {0.5f, 4.0f, 50.0f};
    for (size_t r = 0; r < 3; ++r) {
        make_sheet(positions, normals, r == 1);
        for (uint32_t at = 0; at < POINTS; ++at) {
            stp_near_points list;
            uint32_t begin = at / 100 * 100, count = 100 - at % 50;
            list_points(positions, begin, count, &list);
            const float* p = positions + 3 * (size_t)at;
            stp_vec3 position = {p[0], p[1], p[2]};
            stp_normal_kernels_portable.sum_near(&list, radii[r] * radii[r], position, plain[at]);
            float sum[STP_NORMAL_SUMS] = {0};
            for (uint32_t i = begin; i < begin + count; ++i) { // by definition
                const float* q = positions + 3 * (size_t)i;
                float d[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
                if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= radii[r] * radii[r]) {
                    sum[0] += 1.0f;
                    sum[1] += d[0];
                    sum[6] += d[0] * d[2];
                }
            }
            CHECK(plain[at][0] == sum[0]);
            CHECK(fabsf(plain[at][1] - sum[1]) < 1e-3f * (1.0f + sum[0]));
            CHECK(fabsf(plain[at][6] - sum[6]) < 1e-2f * (1.0f + sum[0]));
            plain[at][0] = stp_max(plain[at][0], 1.0f); // as `project` expects
            if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
                STP_VECTOR(stp_normal_kernels)
                    .sum_near(&list, radii[r] * radii[r], position, wide[at]);
                wide[at][0] = stp_max(wide[at][0], 1.0f);
            }
        }
        stp_normal_kernels_portable.project((const float(*)[STP_NORMAL_SUMS])plain, POINTS,
                                            matrices);
        check_matrices(test, (const float(*)[STP_NORMAL_SUMS])plain, matrices);
        // a matrix depends on no other one
        stp_normal_kernels_portable.project((const float(*)[STP_NORMAL_SUMS])plain + 5, 3, other);
        CHECK(memcmp(matrices[5], other, 3 * sizeof(other[0])) == 0);
        if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
            CHECK(memcmp(plain, wide, sizeof(plain)) == 0);
            STP_VECTOR(stp_normal_kernels)
                .project((const float(*)[STP_NORMAL_SUMS])plain, POINTS, other);
            CHECK(memcmp(matrices, other, sizeof(matrices)) == 0);
        }
    }
}

// Too many neighbours to test all: an even choice of them gives the same plane.
void test_point_normals_of_crowds_are_those_of_the_surface(test_state* test)
{
    static float positions[3 * POINTS], normals[3 * POINTS], truth[3 * POINTS];
    stp_context* context = test_context(NULL, 2, NULL);
    make_sheet(positions, truth, true);
    memset(normals, 0, sizeof(normals));
    stp_candidates candidates = {.count = POINTS, .positions = positions, .normals = normals};
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &candidates, 0.8f));
    uint32_t good = 0;
    for (size_t i = POINTS / 4; i < POINTS; ++i) {
        float cosine = normals[3 * i] * truth[3 * i] + normals[3 * i + 1] * truth[3 * i + 1] +
                       normals[3 * i + 2] * truth[3 * i + 2];
        good += fabsf(cosine) > 0.98f ? 1 : 0;
    }
    CHECK(good > POINTS * 3 / 4 * 9 / 10);
    stp_context_destroy(context);
}

/// The largest angle, in degrees, between estimated normals and that of a plane which is level
/// along x and rises along z.
static double worst_angle(test_state* test, float* positions, uint32_t count, double rise,
                          float radius)
{
    static float normals[3 * POINTS];
    stp_context* context = test_context(NULL, 2, NULL);
    memset(normals, 0, sizeof(normals));
    stp_candidates candidates = {.count = count, .positions = positions, .normals = normals};
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &candidates, radius));
    stp_context_destroy(context);
    double least = 1.0, length = sqrt(1.0 + rise * rise);
    for (size_t i = 0; i < count; ++i) {
        double along = (double)normals[3 * i + 1] - rise * (double)normals[3 * i + 2];
        least = fmin(least, fabs(along) / length);
    }
    return acos(least) * 180.0 / STP_PI;
}

// Rings of a scanner on a slope, with noise: the points within the first radius are in a line.
void test_point_normals_of_rings_are_those_of_the_slope(test_state* test)
{
    static float positions[3 * POINTS];
    uint32_t count = 0;
    for (int ring = 0; ring < 6; ++ring) {
        double distance = 10.0 + 1.5 * ring;
        for (int i = 0; i < 400; ++i, ++count) {
            double turn = 2.0 * STP_PI * i / 400.0;
            double x = distance * cos(turn), z = distance * sin(turn);
            double noise = 0.02 * ((double)random_float(3, count) - 0.5);
            const float p[3] = {(float)x, (float)(0.2 * z + noise), (float)z};
            memcpy(positions + 3 * (size_t)count, p, sizeof(p));
        }
    }
    CHECK(worst_angle(test, positions, count, 0.2, 0.6f) < 4.0);
}

// A line without any neighbours has normals across it.
void test_point_normals_of_a_wire_are_across_it(test_state* test)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    stp_context* context = test_context(NULL, 1, NULL);
    for (uint32_t i = 0; i < 300; ++i) {
        const float p[3] = {0.1f * (float)i, 0.02f * random_float(4, i),
                            0.02f * random_float(5, i)};
        memcpy(positions + 3 * (size_t)i, p, sizeof(p));
    }
    memset(normals, 0, sizeof(normals));
    stp_candidates candidates = {.count = 300, .positions = positions, .normals = normals};
    CHECK_EQUAL(STP_OK, stp_estimate_point_normals(context, &candidates, 0.3f));
    for (size_t i = 0; i < 300; ++i) {
        const float* n = normals + 3 * i;
        CHECK(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-5f);
        CHECK(fabsf(n[0]) < 0.2f);
    }
    stp_context_destroy(context);
}
