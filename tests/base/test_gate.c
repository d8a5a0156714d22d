// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/gate.h"
#include "base/math/rng.h"

#include <stdatomic.h>

enum { JOBS = 400, BUDGET = 1000 };

typedef struct yard {
    stp_context* context;
    stp_gate* gate;
    atomic_uint_fast64_t bytes; ///< sum over the jobs inside
    atomic_uint jobs, bad, alone, done, reports;
    unsigned stop_at; ///< number of the report that stops; 0: none
} yard;

// One in ten is larger than the budget.
static uint64_t job_bytes(size_t i)
{
    return stp_rng_below(5, i, 10) == 0 ? BUDGET + 1 + i : stp_rng_below(6, i, BUDGET + 1);
}

static void count_inner(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    yard* y = user;
    stp_gate_ticket ticket; // a job's own loop enters again without waiting
    if (stp_gate_enter(y->gate, 2 * BUDGET * (end - begin), &ticket) == STP_OK) {
        stp_gate_leave(y->gate, &ticket);
    }
}

static void work(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    yard* y = user;
    for (size_t i = begin; i < end; ++i) {
        uint64_t bytes = job_bytes(i);
        stp_gate_ticket ticket;
        if (stp_gate_enter(y->gate, bytes, &ticket) != STP_OK) {
            return;
        }
        uint64_t inside = atomic_fetch_add(&y->bytes, bytes) + bytes;
        unsigned jobs = atomic_fetch_add(&y->jobs, 1) + 1;
        atomic_fetch_add(&y->bad, inside > BUDGET && jobs > 1);
        atomic_fetch_add(&y->alone, inside > BUDGET && jobs == 1);
        if (i % 16 == 0) {
            stp_parallel_for(y->context, 5, 2, count_inner, y);
        }
        for (unsigned k = 0; k < 2000; ++k) { // lets others enter meanwhile
            atomic_fetch_add(&y->bad, 0);
        }
        atomic_fetch_sub(&y->jobs, 1);
        atomic_fetch_sub(&y->bytes, bytes);
        atomic_fetch_add(&y->done, 1);
        stp_gate_leave(y->gate, &ticket);
    }
}

void test_gate_keeps_jobs_within_the_budget(test_state* test)
{
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        yard y = {.context = test_context(NULL, threads, NULL)};
        CHECK(y.context != NULL);
        CHECK_EQUAL(STP_OK, stp_gate_create(y.context, BUDGET, &y.gate));
        stp_parallel_for(y.context, JOBS, 1, work, &y);
        CHECK_EQUAL(JOBS, y.done);
        CHECK_EQUAL(0, y.bad);
        CHECK(y.alone > 0);
        stp_gate_destroy(y.gate);
        stp_context_destroy(y.context);
    }
}

void test_gate_is_open_to_a_loop_begun_inside(test_state* test)
{
    for (uint32_t threads = 1; threads <= 3; ++threads) {
        yard y = {.context = test_context(NULL, threads, NULL)};
        CHECK(y.context != NULL);
        CHECK_EQUAL(STP_OK, stp_gate_create(y.context, BUDGET, &y.gate));
        stp_gate_ticket outer, again;
        CHECK_EQUAL(STP_OK, stp_gate_enter(y.gate, 5 * BUDGET, &outer)); // alone, so it may enter
        CHECK_EQUAL(STP_OK, stp_gate_enter(y.gate, 5 * BUDGET, &again));
        stp_parallel_for(y.context, JOBS, 1, work, &y); // waits for no thread that waits for it
        CHECK_EQUAL(JOBS, y.done);
        stp_gate_leave(y.gate, &outer); // in any order
        stp_gate_leave(y.gate, &again);
        CHECK_EQUAL(STP_OK, stp_gate_enter(y.gate, 1, &outer));
        stp_gate_leave(y.gate, &outer);
        stp_gate_destroy(y.gate);
        stp_context_destroy(y.context);
    }
}

static int count_report(const stp_progress_report* report, void* user)
{
    (void)report;
    yard* y = user;
    return atomic_fetch_add(&y->reports, 1) + 1 == y->stop_at;
}

// The first ticket stays until the loop has reported a few more times: the calling thread reports
// while it waits in the queue or is inside the gate itself.
static void stay_long(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    yard* y = user;
    for (size_t i = begin; i < end; ++i) {
        stp_gate_ticket ticket;
        if (stp_gate_enter(y->gate, BUDGET, &ticket) != STP_OK) {
            return;
        }
        unsigned before = atomic_load(&y->reports);
        stp_result result = STP_OK;
        while (result == STP_OK && i < 4 && atomic_load(&y->reports) < before + 3) {
            result = stp_progress(y->context, "inside", 0.0);
        }
        stp_gate_leave(y->gate, &ticket);
        atomic_fetch_add(&y->done, 1);
    }
}

void test_gate_does_not_silence_a_loop(test_state* test)
{
    for (unsigned stop_at = 0; stop_at < 12; stop_at += 4) {
        yard y = {.stop_at = stop_at};
        stp_context_desc desc = {.thread_count = 3, .progress = count_report, .progress_user = &y};
        CHECK_EQUAL(STP_OK, stp_context_create(&y.context, &desc));
        CHECK_EQUAL(STP_OK, stp_gate_create(y.context, BUDGET, &y.gate));
        stp_loop_report report = {"work", "nodes", 0};
        stp_result result = stp_parallel_for_reported(y.context, 40, 1, stay_long, &y, &report);
        CHECK_EQUAL(stop_at == 0 ? STP_OK : STP_ERROR_CANCELLED, result);
        CHECK(stop_at == 0 ? y.done == 40 : y.done < 40);
        stp_gate_destroy(y.gate);
        stp_context_destroy(y.context);
    }
}

void test_gate_without_a_budget_is_open(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    yard y = {.context = test_context(&heap, 3, NULL)};
    CHECK(y.context != NULL);
    heap.fail_at = heap.count;
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_gate_create(y.context, 0, &y.gate));
    CHECK_EQUAL(STP_OK, stp_gate_create(y.context, 0, &y.gate));
    stp_parallel_for(y.context, JOBS, 1, work, &y);
    CHECK_EQUAL(JOBS, y.done);
    stp_gate_destroy(y.gate);
    stp_gate_destroy(NULL);
    stp_context_destroy(y.context);
    CHECK_EQUAL(0, heap.live_bytes);
}
