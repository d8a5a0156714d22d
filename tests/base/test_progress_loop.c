// SPDX-License-Identifier: MIT
// Loops that report their progress.
#include "tests.h"

#include "base/core/context.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <string.h>

enum { TASKS = 500 };

typedef struct watch {
    stp_context* context;
    pthread_t caller;
    atomic_uint reports;
    unsigned stop_at; ///< number of the report that stops the loop; 0: none
    bool strange;     ///< from another thread, or decreasing
    stp_progress_report last;
    atomic_uint ran[TASKS]; ///< per task
    atomic_uint cancelled;  ///< tasks that saw the loop stop
    size_t stopping;        ///< task that stops the loop; TASKS: none
    bool adds;              ///< tasks report their progress
} watch;

static int see_report(const stp_progress_report* report, void* user)
{
    watch* w = user;
    unsigned number = atomic_fetch_add(&w->reports, 1) + 1;
    w->strange = w->strange || !pthread_equal(w->caller, pthread_self()) ||
                 strcmp(report->stage, "walk") != 0 || report->fraction < w->last.fraction ||
                 report->overall < w->last.overall || report->done < w->last.done ||
                 report->done > report->total;
    w->last = *report;
    return number == w->stop_at;
}

static stp_context* watched_context(watch* w, uint32_t threads, test_log* log)
{
    w->caller = pthread_self();
    w->stopping = TASKS;
    w->last.overall = -1.0;
    stp_context_desc desc = {.thread_count = threads,
                             .log = test_log_message,
                             .log_user = log,
                             .progress = see_report,
                             .progress_user = w};
    return stp_context_create(&w->context, &desc) == STP_OK ? w->context : NULL;
}

static void count_inner(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    *(size_t*)user += end - begin;
}

static void walk(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    watch* w = user;
    for (size_t i = begin; i < end; ++i) {
        if (i == w->stopping) {
            stp_parallel_stop(w->context);
        }
        while (i > w->stopping && stp_progress(w->context, "inside", 0.5) == STP_OK) {
            // the task that stops the loop may be slow
        }
        // progress reported inside a task is dropped; loops inside it always complete
        if (stp_progress(w->context, "inside", 0.5) == STP_ERROR_CANCELLED) {
            atomic_fetch_add(&w->cancelled, 1);
        }
        size_t inner = 0;
        stp_parallel_for(w->context, 10, 3, count_inner, &inner);
        atomic_fetch_add(&w->ran[i], inner == 10);
        if (w->adds) {
            stp_progress_add(w->context, 1000);
        }
    }
}

// Number of tasks that ran, if they are the first ones; else a number too large.
static size_t count_prefix(watch* w)
{
    size_t count = 0;
    while (count < TASKS && atomic_load(&w->ran[count]) == 1) {
        count += 1;
    }
    for (size_t i = count; i < TASKS; ++i) {
        if (atomic_load(&w->ran[i]) != 0) {
            return SIZE_MAX;
        }
    }
    return count;
}

void test_reported_loop_reports_progress(test_state* test)
{
    static const stp_stage plan[] = {{"before", 1.0}, {"walk", 2.0}, {"after", 1.0}};
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        for (int adds = 0; adds < 2; ++adds) {
            static watch w;
            memset(&w, 0, sizeof(w));
            test_log log = {0};
            stp_context* context = watched_context(&w, threads, &log);
            CHECK(context != NULL);
            w.adds = adds == 1;
            stp_loop_report report = {"walk", adds ? "triangles" : "nodes",
                                      adds ? TASKS * 1000 : 0};
            if (adds == 1) {
                stp_progress_plan(context, plan, 3);
            }
            CHECK_EQUAL(STP_OK, stp_parallel_for_reported(context, TASKS, 1, walk, &w, &report));
            CHECK_EQUAL(TASKS, count_prefix(&w));
            CHECK(!w.strange && w.reports >= 2); // other threads may be faster than the caller
            CHECK(w.last.fraction == 1.0 && w.last.done == w.last.total);
            CHECK_EQUAL(adds ? TASKS * 1000 : TASKS, w.last.total);
            CHECK(strcmp(w.last.unit, report.unit) == 0);
            CHECK(adds ? w.last.overall == 0.75 : w.last.overall < 0.0);
            CHECK_EQUAL(0, log.errors);
            stp_context_destroy(context);
        }
    }
}

void test_reported_loop_stops_on_request(test_state* test)
{
    static const unsigned stops[] = {1, 2, 3, 50, 600};
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        for (int i = 0; i < 5; ++i) {
            static watch w;
            memset(&w, 0, sizeof(w));
            test_log log = {0};
            stp_context* context = watched_context(&w, threads, &log);
            CHECK(context != NULL);
            w.stop_at = stops[i];
            stp_loop_report report = {"walk", "nodes", 0};
            stp_result result = stp_parallel_for_reported(context, TASKS, 1, walk, &w, &report);
            CHECK_EQUAL(w.reports >= stops[i] ? STP_ERROR_CANCELLED : STP_OK, result);
            CHECK_EQUAL(result != STP_OK, log.errors);
            CHECK(result == STP_OK || strcmp(log.text, "stopped while at: walk") == 0);
            CHECK(result == STP_OK || w.reports == stops[i]); // nothing is reported afterwards
            CHECK(count_prefix(&w) <= TASKS);
            CHECK(i > 0 || count_prefix(&w) == 0);
            // a later loop is not affected
            w.stop_at = 0;
            w.last = (stp_progress_report){.overall = -1.0};
            for (size_t k = 0; k < TASKS; ++k) {
                atomic_store(&w.ran[k], 0);
            }
            CHECK_EQUAL(STP_OK, stp_parallel_for_reported(context, TASKS, 7, walk, &w, &report));
            CHECK_EQUAL(TASKS, count_prefix(&w));
            CHECK(!w.strange);
            stp_context_destroy(context);
        }
    }
}

void test_reported_loop_is_stopped_by_a_task(test_state* test)
{
    for (uint32_t threads = 1; threads <= 4; ++threads) {
        static watch w;
        memset(&w, 0, sizeof(w));
        test_log log = {0};
        stp_context* context = watched_context(&w, threads, &log);
        CHECK(context != NULL);
        w.stopping = 20;
        stp_loop_report report = {"walk", "nodes", 0};
        CHECK_EQUAL(STP_ERROR_CANCELLED,
                    stp_parallel_for_reported(context, TASKS, 1, walk, &w, &report));
        size_t ran = count_prefix(&w);
        CHECK(ran >= 21 && ran < TASKS);
        CHECK(w.cancelled >= 1);    // the task itself, and others that were running
        CHECK_EQUAL(0, log.errors); // the task has logged why
        stp_context_destroy(context);
    }
}

typedef struct patience {
    watch w;
    atomic_uint waiting;
} patience;

// A worker's task lasts until the caller has reported a few more times; the caller's lasts until
// such a task exists.
static void wait_for_reports(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)begin, (void)end;
    patience* p = user;
    if (worker == 0) {
        while (atomic_load(&p->waiting) == 0) {
            sched_yield();
        }
        return;
    }
    atomic_fetch_add(&p->waiting, 1);
    unsigned before = atomic_load(&p->w.reports);
    while (atomic_load(&p->w.reports) < before + 3) {
        sched_yield();
    }
}

void test_reported_loop_reports_while_it_waits(test_state* test)
{
    static patience p;
    memset(&p, 0, sizeof(p));
    test_log log = {0};
    stp_context* context = watched_context(&p.w, 2, &log);
    CHECK(context != NULL);
    stp_loop_report report = {"walk", "nodes", 0};
    CHECK_EQUAL(STP_OK, stp_parallel_for_reported(context, 2, 1, wait_for_reports, &p, &report));
    CHECK(p.w.reports >= 4 && !p.w.strange);
    stp_context_destroy(context);
}

static int keep_report(const stp_progress_report* report, void* user)
{
    *(stp_progress_report*)user = *report;
    return 0;
}

void test_progress_of_the_whole_never_goes_back(test_state* test)
{
    stp_progress_report last;
    stp_context_desc desc = {.thread_count = 1, .progress = keep_report, .progress_user = &last};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    CHECK_EQUAL(STP_OK, stp_progress(context, "import", 0.5));
    CHECK(last.overall < 0.0 && last.fraction == 0.5 && last.total == 0 && last.unit == NULL);
    static const stp_stage rough[] = {{"import", 1.0}, {"surfels", 1.0}, {"write", 2.0}};
    static const stp_stage better[] = {{"import", 1.0}, {"surfels", 8.0}, {"write", 1.0}};
    stp_progress_plan(context, rough, 3);
    CHECK_EQUAL(STP_OK, stp_progress(context, "import", 0.5));
    CHECK(last.overall == 0.125);
    CHECK_EQUAL(STP_OK, stp_progress(context, "import", 7.0));
    CHECK(last.overall == 0.25 && last.fraction == 1.0);
    stp_progress_plan(context, better, 3);
    CHECK_EQUAL(STP_OK, stp_progress(context, "surfels", 0.0));
    CHECK(last.overall == 0.25);
    CHECK_EQUAL(STP_OK, stp_progress(context, "surfels", 0.5));
    CHECK(last.overall == 0.5);
    CHECK_EQUAL(STP_OK, stp_progress(context, "something else", 0.9));
    CHECK(last.overall == 0.5);
    CHECK_EQUAL(STP_OK, stp_progress(context, "write", 1.0));
    CHECK(last.overall == 1.0);
    stp_progress_plan(context, NULL, 0);
    CHECK_EQUAL(STP_OK, stp_progress(context, "draw", 0.0));
    CHECK(last.overall < 0.0);
    stp_context_destroy(context);
}
