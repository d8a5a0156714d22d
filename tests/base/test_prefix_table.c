// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/math/math.h"
#include "base/math/rng.h"
#include "base/splats/prefix_table.h"

#include <string.h>

enum { LONGEST = 30000 };

// Radii that fall like those of an order on a surface, with plateaus and steps; `rough` adds
// positive noise.
static void make_radii(float* radii, uint32_t count, uint64_t seed, int rough)
{
    float level = 1.0f;
    for (uint32_t k = 0; k < count; ++k) {
        float unit = (float)(stp_rng_hash(seed, k) >> 40) * 0x1p-24f;
        float smooth = 1.0f / sqrtf((float)(k + 1));
        if (stp_rng_below(seed ^ 5, k, 100) == 0) {
            level *= 0.9f + 0.1f * unit;
        }
        radii[k] = smooth * level * (rough ? 0.1f + unit : 1.0f);
    }
    radii[0] = INFINITY;
}

static int is_conservative(const stp_prefix_table* table, const float* radii, uint32_t count,
                           float final)
{
    float cover = final;
    for (uint32_t n = count; n >= 1; --n) {
        cover = n < count ? stp_max(cover, radii[n]) : final;
        float known = stp_prefix_table_radius(table, n);
        if (!(known >= cover) || known > cover * 2.5f + 1e-30f) {
            return 0;
        }
    }
    return 1;
}

// The shortest prefix, by brute force.
static uint32_t search_count(const stp_prefix_table* table, uint32_t count, float radius)
{
    for (uint32_t n = 1; n < count; ++n) {
        if (stp_prefix_table_radius(table, n) <= radius) {
            return n;
        }
    }
    return count;
}

void test_prefix_table_never_promises_too_much(test_state* test)
{
    static const uint32_t counts[] = {1, 2, 3, 63, 64, 65, 200, 5000, LONGEST};
    static float radii[LONGEST];
    for (uint64_t seed = 1; seed <= 6; ++seed) {
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            uint32_t count = counts[c];
            make_radii(radii, count, seed, seed % 2 == 0);
            float final = seed % 3 == 0 ? 0.0f : 0.9f / sqrtf((float)count) * 0.1f;
            stp_prefix_table table;
            stp_prefix_table_make(&table, radii, count, final);
            CHECK(table.size >= 1 && table.size <= STP_PREFIX_TABLE_SIZE);
            CHECK_EQUAL(1, table.count[0]);
            CHECK_EQUAL(count, table.count[table.size - 1]);
            for (uint32_t i = 1; i < table.size; ++i) {
                CHECK(table.count[i] > table.count[i - 1] &&
                      table.radius[i] <= table.radius[i - 1]);
            }
            if (seed % 2 == 1) {
                CHECK(is_conservative(&table, radii, count, final));
            }
            float cover = final;
            for (uint32_t n = count; n >= 1; --n) {
                cover = n < count ? stp_max(cover, radii[n]) : final;
                CHECK(stp_prefix_table_radius(&table, n) >= cover);
            }
        }
    }
}

void test_prefix_table_finds_the_shortest_prefix(test_state* test)
{
    static float radii[3000];
    make_radii(radii, 3000, 3, 0);
    stp_prefix_table table;
    stp_prefix_table_make(&table, radii, 3000, 0.001f);
    for (uint32_t i = 0; i < 300; ++i) {
        float radius = (float)(stp_rng_hash(9, i) >> 40) * 0x1p-24f;
        radius *= radius * radius;
        CHECK_EQUAL(search_count(&table, 3000, radius), stp_prefix_table_count(&table, radius));
    }
    for (uint32_t n = 1; n <= 3000; n += 7) { // the radius of a prefix requires no longer prefix
        CHECK(stp_prefix_table_count(&table, stp_prefix_table_radius(&table, n)) <= n);
    }
    CHECK_EQUAL(1, stp_prefix_table_count(&table, 10.0f));
    CHECK_EQUAL(3000, stp_prefix_table_count(&table, 0.0f));
}

void test_prefix_table_handles_orders_of_no_points_and_equal_radii(test_state* test)
{
    stp_prefix_table table;
    stp_prefix_table_make(&table, NULL, 0, 0.0f);
    CHECK_EQUAL(0, stp_prefix_table_count(&table, 1.0f));
    CHECK(stp_prefix_table_radius(&table, 5) > 1e30f);
    static float equal[500];
    for (int i = 0; i < 500; ++i) {
        equal[i] = 2.0f;
    }
    stp_prefix_table_make(&table, equal, 500, 0.0f);
    CHECK_EQUAL(1, stp_prefix_table_count(&table, 2.0f));
    CHECK_EQUAL(500, stp_prefix_table_count(&table, 1.9f));
    CHECK(stp_prefix_table_radius(&table, 500) == 0.0f);
    CHECK(stp_prefix_table_radius(&table, 499) == 2.0f);
    memset(equal, 0, sizeof(equal));
    stp_prefix_table_make(&table, equal, 500, 0.0f);
    CHECK_EQUAL(1, stp_prefix_table_count(&table, 0.0f));
}
