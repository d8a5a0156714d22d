// SPDX-License-Identifier: MIT
// The whole test framework: a test is a function, a failed check prints its place and ends it.
#pragma once

#include <stdio.h>

typedef struct test_state {
    int failed;
    const char* skipped; ///< why the test could not run here; NULL: it ran
} test_state;

/// Ends a test that cannot run here, with the reason.
#define SKIP(reason)                                                                               \
    do {                                                                                           \
        test->skipped = (reason);                                                                  \
        return;                                                                                    \
    } while (0)

#define CHECK(condition)                                                                           \
    do {                                                                                           \
        if (!(condition)) {                                                                        \
            fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition);                \
            test->failed = 1;                                                                      \
            return;                                                                                \
        }                                                                                          \
    } while (0)

/// Both sides are printed, so that a log alone tells what happened.
#define CHECK_EQUAL(expected, actual)                                                              \
    do {                                                                                           \
        unsigned long long e_ = (unsigned long long)(expected);                                    \
        unsigned long long a_ = (unsigned long long)(actual);                                      \
        if (e_ != a_) {                                                                            \
            fprintf(stderr, "%s:%d: %s: expected %llu (0x%llx), got %llu (0x%llx)\n", __FILE__,    \
                    __LINE__, #actual, e_, e_, a_, a_);                                            \
            test->failed = 1;                                                                      \
            return;                                                                                \
        }                                                                                          \
    } while (0)
