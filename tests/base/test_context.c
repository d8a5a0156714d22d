// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/context.h"

#include <string.h>

void test_context_counts_live_and_peak_bytes(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    stp_context* context = test_context(&heap, 1, NULL);
    CHECK(context != NULL);
    uint64_t before = stp_context_live_bytes(context);
    void* a = stp_alloc(context, 1000);
    void* b = stp_alloc(context, 5000);
    CHECK(a != NULL && b != NULL);
    CHECK((uintptr_t)a % 64 == 0 && (uintptr_t)b % 64 == 0);
    CHECK(stp_context_live_bytes(context) >= before + 6000);
    uint64_t peak = stp_context_peak_bytes(context);
    CHECK(peak >= before + 6000);
    stp_free(context, b);
    stp_free(context, a);
    stp_free(context, NULL);
    CHECK_EQUAL(before, stp_context_live_bytes(context));
    CHECK_EQUAL(peak, stp_context_peak_bytes(context));
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_context_limit_refuses_and_recovers(test_state* test)
{
    test_log log = {0};
    stp_context_desc desc = {
        .thread_count = 2, .memory_limit_bytes = 100000, .log = test_log_message, .log_user = &log};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    void* maximum = stp_alloc(context, 90000);
    CHECK(maximum != NULL);
    uint64_t live = stp_context_live_bytes(context);
    CHECK(stp_alloc(context, 20000) == NULL);
    CHECK_EQUAL(live, stp_context_live_bytes(context)); // refused bytes are not counted
    CHECK(stp_context_peak_bytes(context) <= 100000);
    stp_free(context, maximum);
    void* again = stp_alloc(context, 90000);
    CHECK(again != NULL);
    stp_free(context, again);
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_fail_memory(context));
    CHECK(strstr(log.text, "100000") !=
          NULL); // the message names the limit, so the user knows what to raise
    CHECK_EQUAL(1, log.errors);
    stp_context_destroy(context);
}

void test_context_counts_what_libraries_take(test_state* test)
{
    test_log log = {0};
    stp_context_desc desc = {.thread_count = 1,
                             .memory_limit_bytes = 5000000,
                             .log = test_log_message,
                             .log_user = &log};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    uint64_t before = stp_context_live_bytes(context);
    CHECK(stp_reserve(context, 3000000));
    CHECK_EQUAL(before + 3000000, stp_context_live_bytes(context));
    CHECK(stp_alloc(context, 3000000) == NULL);
    CHECK(!stp_reserve(context, 4000000) && !stp_reserve(context, UINT64_MAX));
    CHECK_EQUAL(STP_ERROR_OUT_OF_MEMORY, stp_fail_memory(context));
    CHECK(strstr(log.text, "at least 8 MB") != NULL); // 3 + 4, and what the context itself uses
    stp_release(context, 3000000);
    CHECK_EQUAL(before, stp_context_live_bytes(context));
    void* memory = stp_alloc(context, 3000000);
    CHECK(memory != NULL);
    stp_free(context, memory);
    stp_context_destroy(context);
}

void test_context_refuses_impossible_sizes(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    CHECK(stp_alloc(context, SIZE_MAX) == NULL);
    CHECK(stp_alloc(context, SIZE_MAX - 63) == NULL);
    CHECK(stp_alloc_array(context, SIZE_MAX / 2, 4) == NULL);
    CHECK(stp_alloc_zeroed(context, SIZE_MAX, SIZE_MAX) == NULL);
    void* nothing = stp_alloc_array(context, SIZE_MAX, 0); // no bytes: a valid, empty array
    CHECK(nothing != NULL);
    stp_free(context, nothing);
    unsigned char* zero = stp_alloc_zeroed(context, 33, 3);
    CHECK(zero != NULL);
    for (int i = 0; i < 99; ++i) {
        CHECK_EQUAL(0, zero[i]);
    }
    stp_free(context, zero);
    stp_context_destroy(context);
}

void test_make_room_keeps_elements(test_state* test)
{
    test_heap heap = TEST_HEAP(-1);
    stp_context* context = test_context(&heap, 1, NULL);
    CHECK(context != NULL);
    uint32_t* array = NULL;
    size_t capacity = 0;
    for (uint32_t i = 0; i < 5000; ++i) {
        CHECK(STP_MAKE_ROOM(context, array, capacity, i + 1));
        CHECK(capacity > i);
        array[i] = i * 7;
    }
    for (uint32_t i = 0; i < 5000; ++i) {
        CHECK_EQUAL(i * 7, array[i]);
    }
    CHECK(heap.count < 30); // grows by a factor, not by one element
    CHECK(!STP_MAKE_ROOM(context, array, capacity, SIZE_MAX / 2));
    CHECK_EQUAL(4999 * 7, array[4999]); // still valid after a failed growth
    stp_free(context, array);
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
}

void test_context_survives_failing_allocator(test_state* test)
{
    int made = 0;
    for (int n = 0; n < 8; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 4, NULL);
        made += context != NULL;
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made > 0 && made < 8);
}

typedef struct stop_at {
    int calls, stop;
} stop_at;

static int stop_progress(const stp_progress_report* report, void* user)
{
    (void)report;
    stop_at* s = user;
    return ++s->calls == s->stop;
}

void test_progress_stops_work_with_one_message(test_state* test)
{
    test_log log = {0};
    stop_at stop = {.stop = 3};
    stp_context_desc desc = {.thread_count = 1,
                             .log = test_log_message,
                             .log_user = &log,
                             .progress = stop_progress,
                             .progress_user = &stop};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    CHECK_EQUAL(STP_OK, stp_progress(context, "order", 0.0));
    CHECK_EQUAL(STP_OK, stp_progress(context, "order", 0.5));
    CHECK_EQUAL(STP_ERROR_CANCELLED, stp_progress(context, "order", 0.7));
    CHECK_EQUAL(1, log.errors);
    CHECK(strstr(log.text, "order") != NULL);
    stp_context_destroy(context);
}

void test_messages_longer_than_the_buffer_are_truncated(test_state* test)
{
    test_log log = {0};
    stp_context* context = test_context(NULL, 1, &log);
    CHECK(context != NULL);
    char long_name[4000];
    memset(long_name, 'x', sizeof(long_name) - 1);
    long_name[sizeof(long_name) - 1] = 0;
    CHECK_EQUAL(STP_ERROR_IO, stp_fail(context, STP_ERROR_IO, "%s: missing", long_name));
    CHECK_EQUAL(1, log.errors);
    CHECK_EQUAL(sizeof(log.text) - 1, strlen(log.text));
    stp_context_destroy(context);
}

/// The last message and its level.
typedef struct heard {
    stp_log_level level;
    char text[64];
    int count;
} heard;

static void hear(stp_log_level level, const char* message, void* user)
{
    heard* h = user;
    h->level = level;
    h->count += 1;
    snprintf(h->text, sizeof(h->text), "%s", message);
}

void test_messages_have_their_levels(test_state* test)
{
    heard h = {0};
    stp_context* context = NULL;
    const stp_context_desc desc = {.log = hear, .log_user = &h};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    CHECK_EQUAL(STP_ERROR_IO, stp_fail(context, STP_ERROR_IO, "%s is %d", "one", 1));
    CHECK(h.level == STP_LOG_ERROR && h.count == 1 && strcmp(h.text, "one is 1") == 0);
    stp_warn(context, "%s is %d", "two", 2);
    CHECK(h.level == STP_LOG_WARNING && h.count == 2 && strcmp(h.text, "two is 2") == 0);
    stp_notice(context, "%s is %d", "three", 3);
    CHECK(h.level == STP_LOG_NOTICE && h.count == 3 && strcmp(h.text, "three is 3") == 0);
    stp_context_destroy(context);
}

void test_every_result_has_a_text(test_state* test)
{
    int count = 0;
#define X(name, text)                                                                              \
    CHECK(strcmp(stp_result_string(STP_##name), text) == 0);                                       \
    count += 1;
    STP_RESULTS(X)
#undef X
    CHECK(strcmp(stp_result_string((stp_result)count), "unknown result") == 0);
}
