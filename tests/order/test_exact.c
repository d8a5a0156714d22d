// SPDX-License-Identifier: MIT
#include "point_sets.h"
#include "tests.h"

#include "base/core/processor.h"
#include "base/io/hash.h"
#include "order/order_kinds.h"

#include <string.h>

enum { LARGEST = 20000 };

typedef struct exact_case {
    float positions[3 * LARGEST], normals[3 * LARGEST];
    uint32_t order[LARGEST];
    float radii[LARGEST];
    uint32_t count, ordered;
    float final_radius;
} exact_case;

static exact_case* make_case(test_shape shape, uint64_t seed, uint32_t count)
{
    exact_case* c = calloc(1, sizeof(*c));
    if (c != NULL) {
        c->count = count;
        test_make_points(shape, seed, count, c->positions, c->normals);
    }
    return c;
}

static stp_result order_case(stp_context* context, exact_case* c, stp_order_metric metric,
                             uint32_t wanted, uint32_t threads)
{
    stp_order_desc desc = {.metric = metric, .thread_count = threads};
    return stp_order_points(context, &desc, c->positions, c->normals, c->count, wanted, c->order,
                            c->radii, &c->ordered, &c->final_radius, NULL);
}

// The documented squared dissimilarity, straight from the formula.
static float dissimilarity(const exact_case* c, uint32_t i, uint32_t j, float scale,
                           float side_penalty)
{
    const float *p = c->positions + 3 * i, *q = c->positions + 3 * j;
    float x = p[0] * scale - q[0] * scale, y = p[1] * scale - q[1] * scale,
          z = p[2] * scale - q[2] * scale;
    float squared = (x * x + y * y) + z * z;
    const float *n = c->normals + 3 * i, *m = c->normals + 3 * j;
    if (side_penalty > 0.0f && (n[0] * m[0] + n[1] * m[1]) + n[2] * m[2] < 0.0f) {
        squared = (sqrtf(squared) + side_penalty) * (sqrtf(squared) + side_penalty);
    }
    return squared;
}

// Checks an order step by step: each point must have the largest remaining gap, and among equal
// ones the lowest position on the curve.
static int is_exact(stp_context* context, const exact_case* c, stp_order_metric metric)
{
    stp_team team = stp_team_create(context, 1);
    stp_points points = {.positions = c->positions, .normals = c->normals, .count = c->count};
    stp_tree tree;
    uint32_t* ids = malloc(c->count * sizeof(*ids));
    uint32_t* place = malloc(c->count * sizeof(*place));
    float* gaps = malloc(c->count * sizeof(*gaps));
    if (ids == NULL || place == NULL || gaps == NULL ||
        stp_points_measure(&points, &team) != STP_OK ||
        stp_tree_create(context, &tree, c->count, metric == STP_METRIC_SIDE, false) != STP_OK) {
        return 0;
    }
    int good = stp_points_sort(&points, &team, &tree, ids) == STP_OK;
    stp_tree_destroy(context, &tree);
    for (uint32_t i = 0; i < c->count; ++i) {
        gaps[i] = INFINITY;
        place[ids[i]] = i;
    }
    stp_vec3 extent =
        stp_sub(stp_scale(points.box.max, points.scale), stp_scale(points.box.min, points.scale));
    float side_penalty = metric == STP_METRIC_SIDE ? stp_length(extent) : 0.0f;
    for (uint32_t k = 0; k <= c->ordered && good; ++k) {
        uint32_t best = 0;
        for (uint32_t i = 1; i < c->count; ++i) {
            if (gaps[i] > gaps[best] || (gaps[i] == gaps[best] && place[i] < place[best])) {
                best = i;
            }
        }
        float radius = gaps[best] > 0.0f ? sqrtf(gaps[best]) / points.scale : 0.0f;
        if (k == c->ordered) {
            good = radius == c->final_radius;
            break;
        }
        uint32_t chosen = c->order[k];
        good = (k == 0 || chosen == best) && radius == c->radii[k];
        for (uint32_t i = 0; i < c->count; ++i) {
            gaps[i] = stp_min(gaps[i], dissimilarity(c, i, chosen, points.scale, side_penalty));
        }
    }
    free(ids);
    free(place);
    free(gaps);
    return good;
}

static void check_exact(test_state* test, test_shape shape, uint32_t count, uint32_t wanted)
{
    stp_context* context = test_context(NULL, 2, NULL);
    for (uint64_t seed = 1; seed <= 3; ++seed) {
        for (int metric = STP_METRIC_SIDE; metric <= (int)STP_METRIC_EUCLIDEAN; ++metric) {
            exact_case* c = make_case(shape, seed, count);
            CHECK(context != NULL && c != NULL);
            CHECK_EQUAL(STP_OK, order_case(context, c, (stp_order_metric)metric, wanted, 0));
            CHECK(is_exact(context, c, (stp_order_metric)metric));
            free(c);
        }
    }
    stp_context_destroy(context);
}

void test_order_exact_is_greedy_in_boxes(test_state* test)
{
    check_exact(test, TEST_BOX, 1, 1);
    check_exact(test, TEST_BOX, 2, 2);
    check_exact(test, TEST_BOX, 33, 33);
    check_exact(test, TEST_BOX, 700, 700);
    check_exact(test, TEST_BOX, 6000, 300);
}

void test_order_exact_is_greedy_on_spheres(test_state* test)
{
    check_exact(test, TEST_SPHERE, 500, 500);
    check_exact(test, TEST_SPHERE, 7000, 250);
}

void test_order_exact_is_greedy_on_both_sides_of_a_wall(test_state* test)
{
    check_exact(test, TEST_WALL, 500, 500);
    check_exact(test, TEST_WALL, 7000, 250);
}

void test_order_exact_is_greedy_in_clusters(test_state* test)
{
    check_exact(test, TEST_CLUSTERS, 600, 600);
    check_exact(test, TEST_CLUSTERS, 6000, 250);
}

void test_order_exact_is_greedy_on_lattices(test_state* test)
{
    check_exact(test, TEST_LATTICE, 600, 600);
    check_exact(test, TEST_LATTICE, 5000, 300);
}

void test_order_exact_is_greedy_on_lines(test_state* test)
{
    check_exact(test, TEST_LINE, 500, 500);
    check_exact(test, TEST_LINE, 5000, 300);
}

void test_order_exact_is_greedy_where_points_coincide(test_state* test)
{
    check_exact(test, TEST_COPIES, 1, 1);
    check_exact(test, TEST_COPIES, 300, 300);
    check_exact(test, TEST_COPIES, 5000, 5000);
}

void test_order_exact_is_greedy_in_huge_and_tiny_places(test_state* test)
{
    check_exact(test, TEST_HUGE, 500, 500);
    check_exact(test, TEST_TINY, 500, 500);
    check_exact(test, TEST_HUGE, 5000, 200);
    check_exact(test, TEST_TINY, 5000, 200);
}

void test_order_exact_stops_where_points_coincide(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    exact_case* c = make_case(TEST_COPIES, 1, 300);
    CHECK(context != NULL && c != NULL);
    CHECK_EQUAL(STP_OK, order_case(context, c, STP_METRIC_EUCLIDEAN, 300, 0));
    CHECK_EQUAL(15, c->ordered); // 5 by 3 places
    CHECK(c->final_radius == 0.0f);
    c->count = 0;
    CHECK_EQUAL(STP_OK, order_case(context, c, STP_METRIC_SIDE, 10, 0));
    CHECK_EQUAL(0, c->ordered);
    free(c);
    stp_context_destroy(context);
}

void test_order_exact_orders_all_of_a_larger_set(test_state* test)
{
    stp_context* context = test_context(NULL, 2, NULL);
    exact_case* c = make_case(TEST_SPHERE, 5, LARGEST);
    static unsigned char seen[LARGEST];
    memset(seen, 0, sizeof(seen));
    CHECK(context != NULL && c != NULL);
    CHECK_EQUAL(STP_OK, order_case(context, c, STP_METRIC_SIDE, LARGEST, 0));
    CHECK_EQUAL(LARGEST, c->ordered);
    for (uint32_t i = 0; i < c->ordered; ++i) {
        CHECK(c->order[i] < LARGEST && !seen[c->order[i]]);
        CHECK(i == 0 || c->radii[i] <= c->radii[i - 1]);
        seen[c->order[i]] = 1;
    }
    CHECK(c->final_radius == 0.0f);
    free(c);
    stp_context_destroy(context);
}

static stp_hash hash_of(const exact_case* c)
{
    stp_hash hash = stp_hash_bytes((stp_hash){0}, c->order, c->ordered * sizeof(c->order[0]));
    hash = stp_hash_bytes(hash, c->radii, c->ordered * sizeof(c->radii[0]));
    return stp_hash_bytes(hash, &c->final_radius, sizeof(c->final_radius));
}

// The same bytes for any number of threads and any vector width; the golden values also for any
// compiler.
static void check_golden(test_state* test, stp_order_metric metric, uint64_t golden)
{
    exact_case* c = make_case(TEST_WALL, 9, LARGEST);
    CHECK(c != NULL);
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, 3, NULL);
        CHECK(context != NULL);
        for (int p = 0; p < 3; ++p) {
            setenv("STP_PROCESSOR", stp_processor_name((stp_processor)p), 1);
            stp_result result = order_case(context, c, metric, 3000, threads);
            unsetenv("STP_PROCESSOR");
            CHECK_EQUAL(STP_OK, result);
            CHECK_EQUAL(golden, hash_of(c).low);
        }
        stp_context_destroy(context);
    }
    free(c);
}

void test_order_exact_gives_the_same_bytes_everywhere(test_state* test)
{
    check_golden(test, STP_METRIC_SIDE, UINT64_C(0xcfab0da9b61e1251));
    check_golden(test, STP_METRIC_EUCLIDEAN, UINT64_C(0x9cd550c821155e6c));
}

void test_order_exact_prefix_covers_to_its_radius(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    exact_case* c = make_case(TEST_CLUSTERS, 3, 3000);
    CHECK(context != NULL && c != NULL);
    CHECK_EQUAL(STP_OK, order_case(context, c, STP_METRIC_EUCLIDEAN, 400, 0));
    for (uint32_t prefix = 1; prefix <= 400; prefix += 57) {
        float radius = prefix < c->ordered ? c->radii[prefix] : c->final_radius;
        for (uint32_t i = 0; i < c->count; ++i) {
            float nearest = INFINITY;
            for (uint32_t k = 0; k < prefix; ++k) {
                nearest = stp_min(nearest, dissimilarity(c, i, c->order[k], 1.0f, 0.0f));
            }
            CHECK(sqrtf(nearest) <= radius * 1.000001f);
        }
    }
    free(c);
    stp_context_destroy(context);
}

void test_order_exact_survives_any_failed_allocation(test_state* test)
{
    exact_case* c = make_case(TEST_WALL, 2, 6000);
    CHECK(c != NULL);
    int finished = 0;
    for (int n = 0; n < 200 && !finished; ++n) {
        test_heap heap = TEST_HEAP(n);
        test_log log = {0};
        stp_context* context = test_context(&heap, 2, &log);
        if (context != NULL) {
            stp_result result = order_case(context, c, STP_METRIC_SIDE, 200, 0);
            finished = result == STP_OK;
            CHECK(finished ||
                  (result == STP_ERROR_OUT_OF_MEMORY && c->ordered == 0 && log.errors == 1));
            stp_context_destroy(context);
        }
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(finished);
    free(c);
}

void test_order_refuses_positions_that_are_not_finite(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    exact_case* c = make_case(TEST_BOX, 2, 100);
    CHECK(context != NULL && c != NULL);
    c->positions[150] = NAN;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, order_case(context, c, STP_METRIC_SIDE, 10, 0));
    c->positions[150] = INFINITY;
    CHECK_EQUAL(STP_ERROR_ARGUMENT, order_case(context, c, STP_METRIC_SIDE, 10, 0));
    CHECK_EQUAL(2, log.errors);
    free(c);
    stp_context_destroy(context);
}
