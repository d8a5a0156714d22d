// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/context.h"

#include <stdatomic.h>
#include <string.h>

enum { LOOP_COUNT = 10007 };

typedef struct visits {
    stp_context* context;
    size_t count, grain;
    uint32_t thread_count;
    atomic_uint seen[LOOP_COUNT]; ///< how often each element was handed out
    atomic_uint bad;              ///< tasks with wrong bounds or a wrong worker
    atomic_uint inside[8];        ///< tasks per worker right now
} visits;

static void visit_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    visits* v = user;
    bool right = begin < end && end <= v->count && begin % v->grain == 0 &&
                 (end == v->count || end - begin == v->grain) && worker < v->thread_count;
    if (!right || atomic_fetch_add(&v->inside[worker], 1) != 0) {
        atomic_fetch_add(&v->bad, 1);
        return;
    }
    for (size_t i = begin; i < end; ++i) {
        atomic_fetch_add(&v->seen[i], 1);
    }
    atomic_fetch_sub(&v->inside[worker], 1);
}

void test_parallel_for_visits_each_element_once(test_state* test)
{
    static visits v; // too large for the stack
    static const size_t counts[] = {0, 1, 2, 63, 64, 65, 1000, LOOP_COUNT};
    static const size_t grains[] = {1, 7, 64, 5000, 100000};
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        CHECK_EQUAL(threads, stp_context_thread_count(context));
        for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
            for (size_t g = 0; g < sizeof(grains) / sizeof(grains[0]); ++g) {
                memset(&v, 0, sizeof(v));
                v.count = counts[c];
                v.grain = grains[g];
                v.thread_count = threads;
                stp_parallel_for(context, counts[c], grains[g], visit_task, &v);
                CHECK_EQUAL(0, v.bad);
                for (size_t i = 0; i < LOOP_COUNT; ++i) {
                    CHECK_EQUAL(i < counts[c], v.seen[i]);
                }
            }
        }
        stp_context_destroy(context);
    }
}

typedef struct nested {
    stp_context* context;
    atomic_uint sum, bad;
} nested;

static void inner_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    nested* n = user;
    atomic_fetch_add(&n->bad, worker != 0);
    atomic_fetch_add(&n->sum, (unsigned)(end - begin));
}

static void outer_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    nested* n = user;
    for (size_t i = begin; i < end; ++i) {
        stp_parallel_for(n->context, 10, 3, inner_task, n);
    }
}

void test_nested_loops_run_serially(test_state* test)
{
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        stp_context* context = test_context(NULL, threads, NULL);
        CHECK(context != NULL);
        nested n = {.context = context};
        stp_parallel_for(context, 100, 4, outer_task, &n);
        CHECK_EQUAL(1000, n.sum);
        CHECK_EQUAL(0, n.bad);
        stp_context_destroy(context);
    }
}

static void add_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    uint32_t* out = user;
    for (size_t i = begin; i < end; ++i) {
        out[i] += (uint32_t)i; // plain memory: the thread sanitizer detects a missing barrier
    }
}

void test_many_short_loops_hand_their_results_over(test_state* test)
{
    stp_context* context = test_context(NULL, 3, NULL);
    CHECK(context != NULL);
    uint32_t out[64] = {0};
    for (int round = 0; round < 2000; ++round) {
        stp_parallel_for(context, 64, 1, add_task, out);
    }
    for (uint32_t i = 0; i < 64; ++i) {
        CHECK_EQUAL(2000 * i, out[i]);
    }
    stp_context_destroy(context);
}

static void allocating_task(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    stp_context* context = user;
    for (size_t i = begin; i < end; ++i) {
        void* memory = stp_alloc(context, i % 500);
        stp_free(context, memory);
    }
}

void test_all_threads_may_allocate(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    stp_context* context = test_context(&heap, 3, NULL);
    CHECK(context != NULL);
    uint64_t before = stp_context_live_bytes(context);
    stp_parallel_for(context, 5000, 8, allocating_task, context);
    CHECK_EQUAL(before, stp_context_live_bytes(context));
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
}
