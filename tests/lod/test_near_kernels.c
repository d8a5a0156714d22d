// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/processor.h"
#include "base/rng.h"
#include "lod/neighbours_kernels.h"

enum { POINT_COUNT = 400 };

static void make_points(uint64_t seed, float* positions, float* normals)
{
    for (uint32_t i = 0; i < 3 * POINT_COUNT; ++i) { // on a lattice, so that many are as near
        positions[i] = 0.05f * (float)stp_rng_below(seed, 2 * i, 40);
        normals[i] = (float)stp_rng_below(seed, 2 * i + 1, 3) - 1.0f;
    }
}

static bool are_equal(stp_disk_hits a, stp_disk_hits b)
{
    return a.near == b.near && a.of_set == b.of_set && a.cells == b.cells;
}

void test_near_kernels_of_all_processors_agree(test_state* test)
{
#if defined(__x86_64__)
    if (stp_processor_detect() < STP_PROCESSOR_AVX2) {
        SKIP("no AVX2");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static float positions[3 * POINT_COUNT], normals[3 * POINT_COUNT];
    uint32_t hits = 0, found = 0, of_sets = 0;
    for (uint64_t seed = 0; seed < 20; ++seed) {
        make_points(seed, positions, normals);
        stp_grid grid;
        CHECK_EQUAL(STP_OK,
                    stp_grid_create(context, positions, normals, POINT_COUNT, 0.5f, 0.0f, &grid));
        stp_near_ranges ranges = {.count = 2, .begins = {0, 100}, .ends = {37, 390}};
        stp_disk_query query = {.limit = 1.5f, .footprint = 0.2f, .set_footprint = 0.1f};
        query.tangents[0] = (stp_vec3){0.9f, 0.1f, 0.0f};
        query.tangents[1] = (stp_vec3){-0.1f, 0.9f, 0.3f};
        for (uint32_t at = 0; at < POINT_COUNT; at += 5) {
            stp_near_findings a = {{0}, {0}}, b;
            for (int lane = 0; lane < STP_NEAR_LANES; ++lane) {
                a.surfel[lane] = UINT32_MAX, a.squared[lane] = 0.04f;
            }
            b = a;
            stp_near_kernels_portable.find_nearest(&grid, &ranges, &grid, at, 0.0f, &a);
            stp_near_kernels_avx2.find_nearest(&grid, &ranges, &grid, at, 0.0f, &b);
            for (int lane = 0; lane < STP_NEAR_LANES; ++lane) {
                CHECK_EQUAL(a.surfel[lane], b.surfel[lane]);
                CHECK(a.squared[lane] == b.squared[lane]);
                found += a.surfel[lane] != UINT32_MAX;
            }
            query.x = grid.x[at], query.y = grid.y[at], query.z = grid.z[at];
            query.nx = grid.nx[at], query.ny = grid.ny[at], query.nz = grid.nz[at];
            query.first_of_sets = at % 2 == 0 ? 300 : UINT32_MAX;
            for (uint32_t begin = 0; begin < POINT_COUNT; begin += 8) {
                uint32_t end = begin + 1 + begin / 8 % 12;
                end = end < POINT_COUNT ? end : POINT_COUNT;
                stp_disk_hits c = stp_near_kernels_portable.test_samples(&grid, begin, end, &query);
                CHECK(are_equal(c, stp_near_kernels_avx2.test_samples(&grid, begin, end, &query)));
                hits += c.cells != 0, of_sets += c.of_set != 0;
            }
        }
        stp_grid_destroy(context, &grid);
    }
    CHECK(hits > 1000 && found > 100 && of_sets > 100);
    stp_context_destroy(context);
#else
    SKIP("no AVX2");
#endif
}
