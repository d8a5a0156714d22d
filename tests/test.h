// SPDX-License-Identifier: MIT
// The whole test framework: a test is a function. Each test runs in a process and a folder of its
// own (main.c). A failed check prints its place and ends that process at once, also from a helper
// function or another thread. So nothing can hide the message, and no leak is reported.
#pragma once

#include <stdio.h>

typedef struct test_state {
    const char* skipped; ///< why the test could not run here; NULL: it ran
} test_state;

typedef void test_function(test_state* test);

typedef struct named_test {
    const char* name;
    test_function* run;
} named_test;

typedef struct test_counts {
    int passed, failed, skipped;
} test_counts;

enum { TEST_PASSED = 0, TEST_FAILED = 1, TEST_SKIPPED = 77 };

/// Runs a test in a process and a folder of its own, and removes the folder. @return TEST_PASSED,
/// TEST_FAILED or TEST_SKIPPED
int test_run(const char* name, test_function* run);

enum { TEST_JOBS_MAX = 64 };

/// Runs tests as test_run does, up to `jobs` (1 to TEST_JOBS_MAX) at a time, and adds their results
/// to `counts`. The output of a test is printed when it has failed or was skipped.
void test_run_jobs(const named_test wanted[], size_t count, int jobs, test_counts* counts);

/// Prints a message and ends the process of the test as failed.
_Noreturn void test_fail(const char* file, int line, const char* format, ...)
    __attribute__((format(printf, 3, 4)));

/// Ends a test that cannot run here, with the reason.
#define SKIP(reason)                                                                               \
    do {                                                                                           \
        test->skipped = (reason);                                                                  \
        return;                                                                                    \
    } while (0)

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            (void)test;                                                                            \
            test_fail(__FILE__, __LINE__, "failed: %s", #condition);                               \
        }                                                                                          \
    } while (0)

/// Both sides are printed, so a log alone shows what happened.
#define CHECK_EQUAL(expected, actual)                                                              \
    do {                                                                                           \
        unsigned long long e_ = (unsigned long long)(expected);                                    \
        unsigned long long a_ = (unsigned long long)(actual);                                      \
        if (e_ != a_) {                                                                            \
            (void)test;                                                                            \
            test_fail(__FILE__, __LINE__, "%s: expected %llu (0x%llx), got %llu (0x%llx)",         \
                      #actual, e_, e_, a_, a_);                                                    \
        }                                                                                          \
    } while (0)
