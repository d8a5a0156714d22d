// SPDX-License-Identifier: MIT
#define _DEFAULT_SOURCE // setenv
#include "lab/bench/results.h"
#include "lab/kernels/kernels.h"

#include <stdlib.h>
#include <string.h>
#include <time.h>

static const char variable[] = "STP_PROCESSOR";

/// CPU time of this thread, which other processes hardly affect.
static double clock_ns(void)
{
    struct timespec now;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return 1e9 * (double)now.tv_sec + (double)now.tv_nsec;
}

/// Runs one variant once. @return nanoseconds
static double run_once(const kernel* k, kernel_case* c, uint32_t variant)
{
    setenv(variable, stp_processor_name((stp_processor)variant), 1);
    if (k->reset != NULL) {
        k->reset(c);
    } else {
        memset(c->output, 0xFF, c->output_bytes);
    }
    double start = clock_ns();
    k->run(c);
    return clock_ns() - start;
}

static kernel_times summarize(double* ns, uint32_t count)
{
    kernel_times times = {.median = bench_median(ns, count)}; // sorts
    times.min = ns[0];
    times.max = ns[count - 1];
    return times;
}

static bool measure_case(const kernel* k, kernel_case* c, kernel_result* result)
{
    void* expected = stp_arena_alloc(c->arena, c->output_bytes);
    if (expected == NULL) {
        return false;
    }
    double ns[KERNEL_VARIANTS][KERNEL_RUNS_MAX];
    for (uint32_t v = 0; v < result->variants; ++v) { // warms up, too
        run_once(k, c, v);
        if (v == 0) {
            memcpy(expected, c->output, c->output_bytes);
        }
        result->same[v] = memcmp(expected, c->output, c->output_bytes) == 0;
    }
    for (uint32_t i = 0; i < result->runs; ++i) {
        for (uint32_t v = 0; v < result->variants; ++v) {
            ns[v][i] = run_once(k, c, v) / (double)c->elements;
            result->same[v] = result->same[v] && memcmp(expected, c->output, c->output_bytes) == 0;
        }
    }
    for (uint32_t v = 0; v < result->variants; ++v) {
        result->times[v] = summarize(ns[v], result->runs);
    }
    return true;
}

bool kernel_measure(stp_context* context, const kernel* k, uint32_t runs, kernel_result* result)
{
    stp_processor here = stp_processor_detect();
    stp_processor widest = here < k->widest ? here : k->widest;
    const char* given = getenv(variable);
    char* kept = given != NULL ? strdup(given) : NULL;
    stp_arena arena = stp_arena_create(context, 1 << 20);
    kernel_case c = {.arena = &arena};
    *result = (kernel_result){.runs = runs, .variants = (uint32_t)widest + 1};
    bool measured = (given == NULL || kept != NULL) && k->make(&c) && measure_case(k, &c, result);
    result->elements = c.elements;
    if (k->destroy != NULL) {
        k->destroy(&c);
    }
    stp_arena_destroy(&arena);
    if (kept != NULL) {
        setenv(variable, kept, 1);
    } else {
        unsetenv(variable);
    }
    free(kept);
    return measured;
}
