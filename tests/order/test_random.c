// SPDX-License-Identifier: MIT
#include "point_sets.h"
#include "tests.h"

#include <stipple/order.h>

enum { MANY = 60000 };

// As a scanner sees them: in each direction as many points between 1 and 2 m as between 500 and
// 1,000 m, and one stray point far away.
static void make_scan(float* positions)
{
    for (uint32_t i = 0; i < MANY; ++i) {
        float distance = ldexpf(1.0f + test_unit(1, 2 * (uint64_t)i),
                                (int)(test_unit(1, 2 * (uint64_t)i + 1) * 10.0f));
        stp_vec3 p = stp_scale(test_direction(5, i), distance);
        p = i == 17 ? (stp_vec3){1e5f, 0.0f, 0.0f} : p;
        positions[3 * i] = p.x;
        positions[3 * i + 1] = p.y;
        positions[3 * i + 2] = 0.01f * p.z;
    }
}

// Radii of a random order take a few leaves of work a point, also where density varies greatly.
void test_random_order_of_a_scan_takes_little_work(test_state* test)
{
    float* positions = malloc(3 * sizeof(float) * MANY);
    uint32_t* order = malloc(sizeof(*order) * MANY);
    float* radii = malloc(sizeof(*radii) * MANY);
    CHECK(positions != NULL && order != NULL && radii != NULL);
    make_scan(positions);
    uint64_t counts[2] = {0};
    for (uint32_t threads = 1; threads <= 2; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        stp_order_desc desc = {.kind = STP_ORDER_RANDOM, .seed = 9};
        stp_order_report report;
        uint32_t ordered = 0;
        float final_radius = -1.0f;
        CHECK_EQUAL(STP_OK, stp_order_points(context, &desc, positions, NULL, MANY, MANY, order,
                                             radii, &ordered, &final_radius, &report));
        CHECK(ordered == MANY && final_radius == 0.0f);
        counts[threads - 1] = report.distance_count;
        CHECK(report.distance_count >= MANY && report.distance_count < UINT64_C(1000) * MANY);
        stp_context_destroy(context);
    }
    CHECK_EQUAL(counts[0], counts[1]);
    free(positions);
    free(order);
    free(radii);
}
