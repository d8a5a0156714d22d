// SPDX-License-Identifier: MIT
// Normals of clouds without any: the plane through a point's neighbours, with the same bits on all processors.
#include "tests.h"

#include "base/processor.h"
#include "base/rng.h"
#include "lod/point_normals_kernels.h"
#include "lod/points.h"

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

void test_point_normals_have_the_same_sums_everywhere(test_state* test)
{
    static float positions[3 * POINTS], normals[3 * POINTS];
    static float plain[POINTS][STP_NORMAL_SUMS], wide[POINTS][STP_NORMAL_SUMS];
    stp_context* context = test_context(NULL, 1, NULL);
    const float radii[] = {0.05f, 0.4f, 3.0f};
    for (size_t r = 0; r < 3; ++r) {
        make_sheet(positions, normals, r == 1);
        stp_grid grid;
        CHECK_EQUAL(STP_OK, stp_grid_create(context, positions, normals, POINTS, 2.002f * radii[r],
                                            0.0f, &grid));
        stp_sum_neighbours_portable(&grid, radii[r], 0, POINTS, plain);
        for (size_t at = 0; at < POINTS; at += 37) { // by definition
            uint32_t count = 0;
            double x = 0.0;
            for (size_t i = 0; i < POINTS; ++i) {
                float d[3] = {grid.x[i] - grid.x[at], grid.y[i] - grid.y[at],
                              grid.z[i] - grid.z[at]};
                if (d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= radii[r] * radii[r]) {
                    count += 1;
                    x += (double)d[0];
                }
            }
            CHECK(plain[at][0] >= (float)count); // cells that share a bucket are counted twice
            CHECK(plain[at][0] > (float)count || fabs((double)plain[at][1] - x) < 1e-3 * count);
        }
#if defined(__x86_64__)
        if (stp_processor_detect() >= STP_PROCESSOR_AVX2) {
            stp_sum_neighbours_avx2(&grid, radii[r], 0, POINTS, wide);
            CHECK(memcmp(plain, wide, sizeof(plain)) == 0);
        }
#endif
        stp_grid_destroy(context, &grid);
    }
    stp_context_destroy(context);
}
