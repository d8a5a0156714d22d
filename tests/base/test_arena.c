// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/arena.h"

void test_arena_rewind_reuses_memory(test_state* test)
{
    stp_context* context = test_context(NULL, 1, NULL);
    CHECK(context != NULL);
    stp_arena arena = stp_arena_create(context, 256);
    CHECK(stp_arena_alloc(&arena, 10) != NULL);
    stp_arena_mark mark = stp_arena_get_mark(&arena);
    void* first = stp_arena_alloc(&arena, 100);
    CHECK(first != NULL && (uintptr_t)first % 16 == 0);
    CHECK(stp_arena_alloc(&arena, 10000) != NULL); // larger than a block
    stp_arena_rewind(&arena, mark);
    CHECK(stp_arena_alloc(&arena, 100) == first);
    stp_arena_destroy(&arena);
    CHECK_EQUAL(0, stp_arena_get_mark(&arena).block_used);
    stp_context_destroy(context);
}

void test_arena_survives_failing_allocator(test_state* test)
{
    // fail the n-th allocation, for every n until one run gets through: no leak, no crash
    for (int n = 0;; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        if (context == NULL) {
            CHECK_EQUAL(0, heap.live_bytes);
            continue;
        }
        stp_arena arena = stp_arena_create(context, 64);
        int got = 0;
        for (int i = 0; i < 4; ++i) {
            got += stp_arena_alloc(&arena, 64) != NULL;
        }
        stp_arena_destroy(&arena);
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
        if (got == 4) {
            CHECK(n >= 4);
            break;
        }
    }
}
