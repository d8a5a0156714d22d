// SPDX-License-Identifier: MIT
// Shared by all tests: prototypes from the generated list, an allocator that counts and can fail,
// and a context over it.
#pragma once

#include "test.h"

#include <stipple/base.h>

#include <assert.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

#define TEST(name) void test_##name(test_state* test);
#include "test_list.h"
#undef TEST

/// Counts live bytes and fails on request; several threads may use it at once.
typedef struct test_heap {
    int fail_at;  ///< allocations that succeed before one fails; negative: never fail
    bool forever; ///< all later ones fail, too
    int count;
    size_t live_bytes;
    pthread_mutex_t mutex;
} test_heap;

#define TEST_HEAP(fail)                                                                            \
    {                                                                                              \
        .fail_at = (fail), .mutex = PTHREAD_MUTEX_INITIALIZER                                      \
    }

static inline void* test_heap_alloc(size_t size, size_t alignment, void* user)
{
    test_heap* heap = user;
    pthread_mutex_lock(&heap->mutex);
    bool fails = heap->count == heap->fail_at ||
                 (heap->forever && heap->fail_at >= 0 && heap->count > heap->fail_at);
    heap->count += 1;
    heap->live_bytes += fails ? 0 : size;
    pthread_mutex_unlock(&heap->mutex);
    return fails ? NULL : aligned_alloc(alignment, (size + alignment - 1) & ~(alignment - 1));
}

static inline void test_heap_free(void* memory, size_t size, void* user)
{
    test_heap* heap = user;
    pthread_mutex_lock(&heap->mutex);
    assert(heap->live_bytes >= size && "no more is freed than was allocated");
    heap->live_bytes -= size;
    pthread_mutex_unlock(&heap->mutex);
    free(memory);
}

/// The last error and the last warning that a context logged, for tests of messages.
typedef struct test_log {
    char text[512]; ///< the last error
    int errors;
    char warning[512]; ///< the last warning
    int warnings;
} test_log;

static inline void test_log_message(stp_log_level level, const char* message, void* user)
{
    test_log* log = user;
    if (level == STP_LOG_ERROR) {
        snprintf(log->text, sizeof(log->text), "%s", message);
        log->errors += 1;
    } else if (level == STP_LOG_WARNING) {
        snprintf(log->warning, sizeof(log->warning), "%s", message);
        log->warnings += 1;
    }
}

/// A context over `heap` (NULL: malloc) with `threads` workers that logs into `log` (may be NULL).
/// NULL if the heap fails.
static inline stp_context* test_context(test_heap* heap, uint32_t threads, test_log* log)
{
    stp_context_desc desc = {.thread_count = threads};
    if (heap != NULL) {
        desc.allocator =
            (stp_allocator){.alloc = test_heap_alloc, .free = test_heap_free, .user = heap};
    }
    if (log != NULL) {
        desc.log = test_log_message;
        desc.log_user = log;
    }
    stp_context* context = NULL;
    return stp_context_create(&context, &desc) == STP_OK ? context : NULL;
}
