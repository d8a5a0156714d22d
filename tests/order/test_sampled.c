// SPDX-License-Identifier: MIT
#include "point_sets.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/io/hash.h"
#include "order/near_grid.h"

#include <stipple/order.h>

#include <string.h>

enum { MOST = 6000 };

typedef struct sampled_case {
    float positions[3 * MOST], normals[3 * MOST];
    uint32_t order[MOST];
    float radii[MOST];
    uint32_t count, ordered;
    float final_radius;
    stp_order_report report;
} sampled_case;

static sampled_case* make_case(test_shape shape, uint64_t seed, uint32_t count)
{
    sampled_case* c = calloc(1, sizeof(*c));
    if (c != NULL) {
        c->count = count;
        test_make_points(shape, seed, count, c->positions, c->normals);
    }
    return c;
}

static stp_result order_case(stp_context* context, sampled_case* c, stp_order_desc desc,
                             uint32_t wanted)
{
    return stp_order_points(context, &desc, c->positions, NULL, c->count, wanted, c->order,
                            c->radii, &c->ordered, &c->final_radius, &c->report);
}

static float distance_between(const sampled_case* c, uint32_t i, uint32_t j)
{
    const float *p = c->positions + 3 * i, *q = c->positions + 3 * j;
    return stp_length((stp_vec3){p[0] - q[0], p[1] - q[1], p[2] - q[2]});
}

static int nearly(float a, float b)
{
    return fabsf(a - b) <= 1e-5f * fabsf(b);
}

static const stp_order_kind kinds[] = {STP_ORDER_RANDOM, STP_ORDER_PAPER_FAST, STP_ORDER_PAPER_TEXT,
                                       STP_ORDER_BEST_OF_K};

void test_sampled_orders_are_permutations_with_true_radii(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    CHECK(context != NULL);
    for (int shape = 0; shape < (int)TEST_HUGE; ++shape) {
        for (size_t k = 0; k < sizeof(kinds) / sizeof(kinds[0]); ++k) {
            sampled_case* c = make_case((test_shape)shape, 4, 400);
            static unsigned char seen[400];
            memset(seen, 0, sizeof(seen));
            CHECK(c != NULL);
            stp_order_desc desc = {.kind = kinds[k], .seed = 3, .samples = 30, .interval = 20};
            CHECK_EQUAL(STP_OK, order_case(context, c, desc, 400));
            CHECK_EQUAL(400, c->ordered);
            CHECK(c->final_radius == 0.0f && c->radii[0] == INFINITY);
            for (uint32_t i = 0; i < 400; ++i) {
                CHECK(c->order[i] < 400 && !seen[c->order[i]]);
                seen[c->order[i]] = 1;
                float nearest = INFINITY;
                for (uint32_t j = 0; j < i; ++j) {
                    nearest = stp_min(nearest, distance_between(c, c->order[i], c->order[j]));
                }
                CHECK(i == 0 || nearly(c->radii[i], nearest));
            }
            free(c);
        }
    }
    stp_context_destroy(context);
}

// Number of neighbours that the published schedules look up for `wanted` surfels.
static uint64_t lookups(stp_order_kind kind, uint32_t wanted, uint32_t interval)
{
    uint64_t count = 0, chosen = 1, round = 0;
    uint32_t samples = 200, accepted = kind == STP_ORDER_PAPER_FAST ? 0 : 1;
    while (chosen < wanted) {
        count += samples;
        chosen += accepted;
        if (kind == STP_ORDER_PAPER_FAST && round % interval == 0) {
            samples = samples / 2 > 20 ? samples / 2 : 20;
            accepted = accepted + 1 < samples * 3 / 10 ? accepted + 1 : samples * 3 / 10;
        }
        round += 1;
        accepted += kind == STP_ORDER_PAPER_TEXT && round % interval == 0;
    }
    return count;
}

void test_sampled_orders_follow_their_schedules(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    sampled_case* c = make_case(TEST_SPHERE, 1, MOST);
    CHECK(context != NULL && c != NULL);
    stp_order_desc fast = {.kind = STP_ORDER_PAPER_FAST, .interval = 50};
    CHECK_EQUAL(STP_OK, order_case(context, c, fast, 2000));
    CHECK_EQUAL(lookups(STP_ORDER_PAPER_FAST, 2000, 50), c->report.distance_count);
    stp_order_desc text = {.kind = STP_ORDER_PAPER_TEXT, .interval = 50};
    CHECK_EQUAL(STP_OK, order_case(context, c, text, 2000));
    CHECK_EQUAL(lookups(STP_ORDER_PAPER_TEXT, 2000, 50), c->report.distance_count);
    stp_order_desc best = {.kind = STP_ORDER_BEST_OF_K, .samples = 40};
    CHECK_EQUAL(STP_OK, order_case(context, c, best, 500));
    CHECK_EQUAL(40 * 499, c->report.distance_count);
    // lookups implied by the published times of 10k, 50k and 100k surfels
    CHECK_EQUAL(416040, lookups(STP_ORDER_PAPER_FAST, 100000, 500));
    free(c);
    stp_context_destroy(context);
}

void test_sampled_orders_are_between_random_and_exact(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    sampled_case* c = make_case(TEST_SPHERE, 8, MOST);
    CHECK(context != NULL && c != NULL);
    float radii[5];
    static const stp_order_kind better[] = {STP_ORDER_RANDOM, STP_ORDER_PAPER_FAST,
                                            STP_ORDER_PAPER_TEXT, STP_ORDER_BEST_OF_K,
                                            STP_ORDER_EXACT};
    for (int k = 0; k < 5; ++k) {
        stp_order_desc desc = {.kind = better[k], .interval = 20};
        CHECK_EQUAL(STP_OK, order_case(context, c, desc, 500));
        radii[k] = c->final_radius;
    }
    CHECK(radii[1] < 0.9f * radii[0] && radii[2] < 0.9f * radii[0]);
    CHECK(radii[3] < radii[1] && radii[4] < radii[3]);
    free(c);
    stp_context_destroy(context);
}

// The best of all remaining points is the farthest point.
void test_sampled_best_of_all_is_greedy(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    sampled_case* c = make_case(TEST_BOX, 6, 300);
    CHECK(context != NULL && c != NULL);
    stp_order_desc desc = {.kind = STP_ORDER_BEST_OF_K, .samples = 300};
    CHECK_EQUAL(STP_OK, order_case(context, c, desc, 100));
    for (uint32_t k = 1; k < 100; ++k) {
        float farthest = 0.0f;
        for (uint32_t i = 0; i < 300; ++i) {
            float nearest = INFINITY;
            for (uint32_t j = 0; j < k; ++j) {
                nearest = stp_min(nearest, distance_between(c, i, c->order[j]));
            }
            farthest = stp_max(farthest, nearest);
        }
        CHECK(nearly(c->radii[k], farthest));
    }
    free(c);
    stp_context_destroy(context);
}

void test_sampled_orders_drop_near_samples(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    sampled_case* c = make_case(TEST_SPHERE, 6, 2000);
    CHECK(context != NULL && c != NULL);
    stp_order_desc desc = {.kind = STP_ORDER_PAPER_TEXT, .drop_factor = 0.5f};
    CHECK_EQUAL(STP_OK, order_case(context, c, desc, 2000));
    CHECK(c->ordered > 50 && c->ordered < 2000); // the input ran empty before all were chosen
    free(c);
    stp_context_destroy(context);
}

void test_sampled_orders_give_the_same_bytes_everywhere(test_state* test)
{
    static const uint64_t golden[] = {UINT64_C(0xbec10b0f838111a6), UINT64_C(0x81c714bf18be049c),
                                      UINT64_C(0x9754835ccf7dc93a), UINT64_C(0xcccf281456e1351b)};
    for (uint32_t threads = 1; threads <= 2; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        sampled_case* c = make_case(TEST_CLUSTERS, 2, 3000);
        CHECK(context != NULL && c != NULL);
        for (size_t k = 0; k < sizeof(kinds) / sizeof(kinds[0]); ++k) {
            for (int p = 0; p < 3; ++p) {
                stp_order_desc desc = {.kind = kinds[k], .seed = 11, .interval = 30};
                setenv("STP_PROCESSOR", stp_processor_name((stp_processor)p), 1);
                stp_result result = order_case(context, c, desc, 700);
                unsetenv("STP_PROCESSOR");
                CHECK_EQUAL(STP_OK, result);
                stp_hash hash = stp_hash_bytes((stp_hash){0}, c->order, 700 * sizeof(c->order[0]));
                hash = stp_hash_bytes(hash, c->radii, 700 * sizeof(c->radii[0]));
                hash = stp_hash_bytes(hash, &c->final_radius, sizeof(c->final_radius));
                CHECK_EQUAL(golden[k], hash.low);
            }
        }
        free(c);
        stp_context_destroy(context);
    }
}

void test_sampled_orders_survive_any_failed_allocation(test_state* test)
{
    sampled_case* c = make_case(TEST_BOX, 2, 2000);
    CHECK(c != NULL);
    for (size_t k = 0; k < sizeof(kinds) / sizeof(kinds[0]); ++k) {
        int finished = 0;
        for (int n = 0; n < 100 && !finished; ++n) {
            test_heap heap = TEST_HEAP(n);
            test_log log = {0};
            stp_context* context = test_context(&heap, 1, &log);
            if (context != NULL) {
                stp_order_desc desc = {.kind = kinds[k], .samples = 20};
                stp_result result = order_case(context, c, desc, 300);
                finished = result == STP_OK;
                CHECK(finished || (result == STP_ERROR_OUT_OF_MEMORY && log.errors == 1));
                stp_context_destroy(context);
            }
            CHECK_EQUAL(0, heap.live_bytes);
        }
        CHECK(finished);
    }
    free(c);
}

void test_near_grid_finds_the_nearest_of_any_points(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    for (int shape = 0; shape < (int)TEST_HUGE; ++shape) {
        sampled_case* c = make_case((test_shape)shape, 3, 1200);
        CHECK(c != NULL);
        stp_box box = stp_box_empty();
        for (uint32_t i = 0; i < c->count; ++i) {
            const float* p = c->positions + 3 * i;
            stp_box_add(&box, (stp_vec3){p[0], p[1], p[2]});
        }
        stp_vec3 size = stp_sub(box.max, box.min);
        stp_near_grid grid;
        CHECK_EQUAL(STP_OK, stp_near_grid_create(context, &grid,
                                                 (float[3]){box.min.x, box.min.y, box.min.z},
                                                 stp_max(stp_max(size.x, size.y), size.z)));
        for (uint32_t i = 0; i < c->count; ++i) {
            const float* p = c->positions + 3 * i;
            float nearest = INFINITY, wide, plain;
            for (uint32_t j = 0; j < i; ++j) {
                const float* q = c->positions + 3 * j;
                stp_vec3 d = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
                nearest = stp_min(nearest, (d.x * d.x + d.y * d.y) + d.z * d.z);
            }
            stp_near_grid_nearest_select()(&grid, p, 1, &wide);
            stp_near_grid_nearest_portable(&grid, p, 1, &plain);
            CHECK(wide == nearest && plain == nearest);
            CHECK_EQUAL(STP_OK, stp_near_grid_add(&grid, p[0], p[1], p[2]));
        }
        stp_near_grid_destroy(&grid);
        free(c);
    }
    stp_context_destroy(context);
}
