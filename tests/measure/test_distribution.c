// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "lab/measure/distribution.h"

#include <string.h>

enum { MOST = 3000 };

static float points[3 * MOST];

static void make_points(uint64_t seed, uint32_t count, int kind)
{
    for (uint32_t i = 0; i < 3 * count; ++i) {
        points[i] = (float)(stp_rng_hash(seed, i) >> 40) * 0x1p-24f;
        if (kind == 1) {
            points[i] = i % 3 == 2 ? 0.0f : points[i]; // planar
        } else if (kind == 2) {
            points[i] = (float)stp_rng_below(seed, i, 4); // many duplicates
        }
    }
}

static double squared_between(const float* p, const float* q)
{
    double x = (double)p[0] - (double)q[0], y = (double)p[1] - (double)q[1],
           z = (double)p[2] - (double)q[2];
    return x * x + y * y + z * z;
}

static double search_all(uint32_t count, const float* p, uint32_t except)
{
    double best = (double)INFINITY;
    for (uint32_t i = 0; i < count; ++i) {
        double squared = squared_between(points + 3 * i, p);
        best = i != except && squared < best ? squared : best;
    }
    return best;
}

void test_nearest_agrees_with_trying_all(test_state* test)
{
    static const uint32_t counts[] = {1, 2, 8, 9, 17, 100, 1000};
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int kind = 0; kind < 3; ++kind) {
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            make_points(c + 1, counts[c], kind);
            stp_nearest tree;
            CHECK_EQUAL(STP_OK, stp_nearest_create(context, &tree, points, counts[c]));
            for (uint32_t i = 0; i < counts[c]; ++i) {
                CHECK(stp_nearest_squared(&tree, points + 3 * i, i) ==
                      search_all(counts[c], points + 3 * i, i));
            }
            for (uint32_t i = 0; i < 100; ++i) {
                float p[3] = {0.01f * (float)i, 0.5f, 1.5f - 0.02f * (float)i};
                CHECK(stp_nearest_squared(&tree, p, UINT32_MAX) ==
                      search_all(counts[c], p, UINT32_MAX));
            }
            stp_nearest_destroy(context, &tree);
        }
    }
    stp_context_destroy(context);
}

void test_distribution_agrees_with_trying_all(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (int kind = 0; kind < 3; ++kind) {
        make_points(7, MOST, kind);
        uint32_t count = 200;
        static float spacings[200];
        stp_distribution d;
        CHECK_EQUAL(STP_OK,
                    stp_distribution_measure(context, points, count, points, MOST, spacings, &d));
        double minimum = (double)INFINITY, maximum = 0.0;
        uint32_t below_median = 0, above_median = 0, uncovered = 0;
        for (uint32_t i = 0; i < count; ++i) {
            double spacing = sqrt(search_all(count, points + 3 * i, i));
            CHECK(spacings[i] == (float)spacing);
            minimum = spacing < minimum ? spacing : minimum;
            below_median += (double)spacings[i] <= d.spacing_median;
            above_median += (double)spacings[i] >= d.spacing_median;
        }
        for (uint32_t i = 0; i < MOST; ++i) {
            double distance = (double)(float)sqrt(search_all(count, points + 3 * i, UINT32_MAX));
            maximum = distance > maximum ? distance : maximum;
            uncovered += distance > d.spacing_median;
        }
        CHECK(d.spacing_min == (double)(float)minimum && d.coverage_max == maximum);
        CHECK(below_median >= count / 2 && above_median >= count / 2);
        CHECK(d.coverage_p50 <= d.coverage_p99 && d.coverage_p99 <= d.coverage_max);
        CHECK(d.uncovered_fraction == (double)uncovered / MOST);
    }
    stp_context_destroy(context);
}

// A square lattice is not the densest packing: its spacing is 0.93 of a hexagonal one's.
void test_distribution_compares_spacing_with_the_best_packing(test_state* test)
{
    enum { SIDE = 300 };
    stp_context* context = test_context(NULL, 2, NULL);
    static float plane[3 * SIDE * SIDE], lattice[3 * 900];
    for (uint32_t i = 0; i < SIDE * SIDE; ++i) {
        float u = (float)(i % SIDE) / SIDE, v = (float)(i / SIDE) / SIDE;
        plane[3 * i] = u + 0.3f * v; // oblique to the axes, like most surfaces
        plane[3 * i + 1] = v - 0.3f * u;
        plane[3 * i + 2] = 0.7f * u + 0.5f * v;
    }
    for (uint32_t i = 0; i < 900; ++i) {
        memcpy(lattice + 3 * i, plane + 3 * (i / 30 * 10 * SIDE + i % 30 * 10), 3 * sizeof(float));
    }
    stp_distribution d;
    CHECK(context != NULL);
    CHECK_EQUAL(STP_OK,
                stp_distribution_measure(context, lattice, 900, plane, SIDE * SIDE, NULL, &d));
    CHECK(d.relative_spacing_min > 0.7 && d.relative_spacing_min < 1.1);
    stp_context_destroy(context);
}

void test_distribution_of_few_points(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_distribution d;
    CHECK(context != NULL);
    make_points(1, 10, 0);
    CHECK_EQUAL(STP_OK, stp_distribution_measure(context, points, 0, points, 10, NULL, &d));
    CHECK_EQUAL(0, d.count);
    CHECK_EQUAL(STP_OK, stp_distribution_measure(context, points, 1, points, 1, NULL, &d));
    CHECK(d.coverage_max == 0.0 && d.relative_spacing_min == 0.0);
    stp_context_destroy(context);
}

void test_distribution_survives_any_failed_allocation(test_state* test)
{
    make_points(3, 500, 0);
    int finished = 0;
    for (int n = 0; n < 100 && !finished; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 2, &log);
        if (context != NULL) {
            stp_distribution d;
            stp_result result =
                stp_distribution_measure(context, points, 100, points, 500, NULL, &d);
            finished = result == STP_OK;
            CHECK(finished || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(finished);
}
