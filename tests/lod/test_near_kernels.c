// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/processor.h"
#include "base/math/rng.h"
#include "lod/grid.h"
#include "lod/neighbours_kernels.h"

#include <string.h>

enum { POINT_COUNT = 400 };

static void make_points(uint64_t seed, float* positions, float* normals)
{
    for (uint32_t i = 0; i < 3 * POINT_COUNT;
         ++i) { // on a lattice, so that many distances are equal
        positions[i] = 0.05f * (float)stp_rng_below(seed, 2 * i, 40);
        normals[i] = (float)stp_rng_below(seed, 2 * i + 1, 3) - 1.0f;
    }
}

// @return number of samples with a surfel nearby; UINT32_MAX if kernels differ
static uint32_t compare_nearest(const stp_grid* grid, const stp_near_ranges* ranges)
{
    stp_near_rule rule = {.limit = 0.04f, .min_agreement = 0.0f};
    uint32_t near = 0;
    for (uint32_t at = 0; at < POINT_COUNT; at += 7) {
        uint32_t end = at + 1 + at % 40 < POINT_COUNT ? at + 1 + at % 40 : POINT_COUNT;
        if (stp_near_kernels_portable.find_run(grid, at, end) !=
            STP_VECTOR(stp_near_kernels).find_run(grid, at, end)) {
            return UINT32_MAX;
        }
        uint32_t a[POINT_COUNT], b[POINT_COUNT];
        memset(a, 7, sizeof(a)); // only the requested entries may be written
        memset(b, 7, sizeof(b));
        stp_near_kernels_portable.find_nearest(grid, ranges, grid, at, end, rule, a);
        STP_VECTOR(stp_near_kernels).find_nearest(grid, ranges, grid, at, end, rule, b);
        if (memcmp(a, b, sizeof(a)) != 0) {
            return UINT32_MAX;
        }
        for (uint32_t i = at; i < end; ++i) {
            near += a[i] != UINT32_MAX;
        }
    }
    return near;
}

static bool are_equal(const stp_disk* a, const stp_disk* b, bool until_full)
{
    return a->full == b->full &&
           ((a->full && until_full) ||
            (a->cells == b->cells && a->count == b->count && a->fractions == b->fractions));
}

// @return number of disks with samples; UINT32_MAX if kernels differ
static uint32_t compare_disks(const stp_grid* grid, const stp_near_ranges* ranges,
                              const stp_stencil* stencil)
{
    static uint16_t fractions[POINT_COUNT];
    stp_disk_query query = {
        .limit = 1.5f, .footprint = 0.2f, .set_footprint = 0.1f, .set_weight = 5};
    query.stencil = stencil;
    query.tangents[0] = (stp_vec3){0.9f, 0.1f, 0.0f};
    query.tangents[1] = (stp_vec3){-0.1f, 0.9f, 0.3f};
    uint32_t hit = 0;
    for (uint32_t at = 0; at < POINT_COUNT; ++at) {
        fractions[at] = (uint16_t)(37 * at);
        query.x = grid->x[at], query.y = grid->y[at], query.z = grid->z[at];
        query.nx = grid->nx[at], query.ny = grid->ny[at], query.nz = grid->nz[at];
        query.first_of_sets = at % 2 == 0 ? 300 : UINT32_MAX;
        query.fractions = at % 3 == 0 ? fractions : NULL;
        query.until_full = at % 5 == 0;
        query.footprint = at % 7 == 0 ? 0.6f : 0.05f;
        stp_disk a = {0}, b = {0};
        bool full = stp_near_kernels_portable.scan_disk(grid, ranges, &query, &a);
        if (full != STP_VECTOR(stp_near_kernels).scan_disk(grid, ranges, &query, &b) ||
            !are_equal(&a, &b, query.until_full)) {
            return UINT32_MAX;
        }
        hit += a.count != 0;
    }
    return hit;
}

static bool are_buckets_equal(const stp_grid* grid, const float* positions)
{
    uint32_t a[POINT_COUNT] = {0}, b[POINT_COUNT] = {0};
    for (size_t stride = 1; stride < 5; ++stride) {
        stp_grid_points columns = {grid->x, grid->y, grid->z, stride};
        stp_grid_points triples = {positions, positions + 1, positions + 2, 3};
        const stp_grid_points* points = stride == 4 ? &triples : &columns;
        size_t end = POINT_COUNT / points->stride;
        stp_grid_kernels_portable.find_buckets(grid, points, 3, end, a);
        STP_VECTOR(stp_grid_kernels).find_buckets(grid, points, 3, end, b);
        if (memcmp(a, b, sizeof(a)) != 0) {
            return false;
        }
    }
    return true;
}

void test_near_kernels_of_all_processors_agree(test_state* test)
{
    if (stp_processor_detect() < STP_PROCESSOR_VECTOR) {
        SKIP("this processor has no vectors");
    }
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    static float positions[3 * POINT_COUNT], normals[3 * POINT_COUNT];
    stp_stencil stencil = stp_stencil_make();
    uint32_t hits = 0, found = 0;
    for (uint64_t seed = 0; seed < 20; ++seed) {
        make_points(seed, positions, normals);
        stp_grid grid;
        CHECK_EQUAL(STP_OK,
                    stp_grid_create(context, positions, normals, POINT_COUNT, 0.5f, 0.1f, &grid));
        stp_near_ranges few = {.count = 2, .begins = {0, 100}, .ends = {37, 160}};
        stp_near_ranges many = {.count = 2, .begins = {0, 100}, .ends = {37, 390}};
        uint32_t near = compare_nearest(&grid, seed % 2 == 0 ? &few : &many);
        uint32_t hit = compare_disks(&grid, &many, &stencil);
        CHECK(near != UINT32_MAX && hit != UINT32_MAX);
        found += near, hits += hit;
        CHECK(are_buckets_equal(&grid, positions));
        for (uint32_t i = 0; i < POINT_COUNT; ++i) {
            stp_vec3 place = {0.01f * (float)i, 1.0f, 0.5f};
            uint32_t count = i / STP_NEAR_LANES * STP_NEAR_LANES;
            float a =
                stp_near_kernels_portable.nearest_squared(grid.x, grid.y, grid.z, count, place);
            float b =
                STP_VECTOR(stp_near_kernels).nearest_squared(grid.x, grid.y, grid.z, count, place);
            CHECK(a == b);
        }
        stp_grid_destroy(context, &grid);
    }
    CHECK(hits > 1000 && found > 100);
    stp_context_destroy(context);
}
