// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/context.h"
#include "base/core/context_internal.h"
#include "base/core/large_blocks.h"

#include <string.h>
#include <unistd.h>

#define KILOBYTE ((size_t)1 << 10)
#define MEGABYTE ((size_t)1 << 20)

static uint32_t next_random(uint32_t* state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

// Marks pages, which detects overlapping blocks.
static void fill(unsigned char* block, size_t size, unsigned char value)
{
    for (size_t i = 0; i < size; i += KILOBYTE) {
        block[i] = value;
    }
    block[size - 1] = value;
}

static int is_filled(const unsigned char* block, size_t size, unsigned char value)
{
    for (size_t i = 0; i < size; i += KILOBYTE) {
        if (block[i] != value) {
            return 0;
        }
    }
    return block[size - 1] == value;
}

void test_large_blocks_never_overlap_and_keep_their_limit(test_state* test)
{
    enum { SLOTS = 12, ROUNDS = 1500 };
    unsigned char* blocks[SLOTS] = {0};
    size_t sizes[SLOTS] = {0};
    stp_large_blocks large;
    stp_large_blocks_open(&large);
    uint32_t state = 7;
    for (int round = 0; round < ROUNDS; ++round) {
        size_t at = next_random(&state) % SLOTS, maximum = next_random(&state) % (8 * MEGABYTE);
        if (blocks[at] != NULL) {
            CHECK(is_filled(blocks[at], sizes[at], (unsigned char)at));
            stp_large_free(&large, blocks[at], sizes[at], maximum);
            blocks[at] = NULL;
        } else {
            size_t scale = (size_t)1 << next_random(&state) % 14;
            sizes[at] = 1 + next_random(&state) % (KILOBYTE * scale);
            blocks[at] = stp_large_alloc(&large, sizes[at], maximum);
            CHECK(blocks[at] != NULL);
            CHECK_EQUAL(0, (uintptr_t)blocks[at] % (size_t)sysconf(_SC_PAGESIZE));
            fill(blocks[at], sizes[at], (unsigned char)at);
        }
        size_t sum = 0;
        for (size_t i = 0; i < large.kept_count; ++i) {
            sum += large.kept[i].size;
        }
        CHECK_EQUAL(sum, large.kept_bytes);
        CHECK(large.kept_bytes <= maximum);
        CHECK(large.kept_count <= STP_LARGE_KEPT_LIMIT);
    }
    for (size_t i = 0; i < SLOTS; ++i) {
        if (blocks[i] != NULL) {
            CHECK(is_filled(blocks[i], sizes[i], (unsigned char)i));
            stp_large_free(&large, blocks[i], sizes[i], 0);
        }
    }
    CHECK_EQUAL(0, large.kept_bytes);
    stp_large_blocks_close(&large);
}

void test_large_blocks_are_reused(test_state* test)
{
    stp_large_blocks large;
    stp_large_blocks_open(&large);
    unsigned char* all = stp_large_alloc(&large, 12 * MEGABYTE, SIZE_MAX);
    CHECK(all != NULL);
    stp_large_free(&large, all, 12 * MEGABYTE, SIZE_MAX);
    CHECK_EQUAL(12 * MEGABYTE, large.kept_bytes);
    // what exceeds the request stays cached
    CHECK(stp_large_alloc(&large, 5 * MEGABYTE, SIZE_MAX) == all);
    CHECK(stp_large_alloc(&large, 3 * MEGABYTE, SIZE_MAX) == all + 5 * MEGABYTE);
    CHECK_EQUAL(4 * MEGABYTE, large.kept_bytes);
    stp_large_free(&large, all, 5 * MEGABYTE, SIZE_MAX);
    CHECK_EQUAL(2, large.kept_count);
    // the smallest sufficient block
    CHECK(stp_large_alloc(&large, 4 * MEGABYTE, SIZE_MAX) == all + 8 * MEGABYTE);
    CHECK_EQUAL(5 * MEGABYTE, large.kept_bytes);
    // adjacent blocks are joined again
    stp_large_free(&large, all + 8 * MEGABYTE, 4 * MEGABYTE, SIZE_MAX);
    stp_large_free(&large, all + 5 * MEGABYTE, 3 * MEGABYTE, SIZE_MAX);
    CHECK_EQUAL(1, large.kept_count);
    CHECK(stp_large_alloc(&large, 12 * MEGABYTE, SIZE_MAX) == all);
    CHECK_EQUAL(0, large.kept_bytes);
    CHECK(stp_large_alloc(&large, SIZE_MAX, 0) == NULL);
    CHECK(stp_large_alloc(&large, SIZE_MAX - 1, SIZE_MAX) == NULL);
    // no more is returned to the system than necessary
    stp_large_free(&large, all, 12 * MEGABYTE, SIZE_MAX);
    CHECK(stp_large_alloc(&large, 2 * MEGABYTE, 7 * MEGABYTE) == all);
    CHECK_EQUAL(7 * MEGABYTE, large.kept_bytes);
    stp_large_free(&large, all, 2 * MEGABYTE, 0);
    CHECK_EQUAL(0, large.kept_bytes);
    stp_large_blocks_close(&large);
}

void test_large_blocks_can_be_forgotten_in_part(test_state* test)
{
    stp_large_blocks large;
    stp_large_blocks_open(&large);
    size_t size = 2 * MEGABYTE, page = (size_t)sysconf(_SC_PAGESIZE);
    unsigned char* block = stp_large_alloc(&large, size, 0);
    CHECK(block != NULL);
    memset(block, 7, size);
    stp_large_discard(block + 1, 3 * page); // it contains two whole pages
    stp_large_discard(block + 5 * page + 1, page);
    for (size_t i = 0; i < size; ++i) {
        CHECK(block[i] == (i >= page && i < 3 * page ? 0 : 7));
    }
    stp_large_free(&large, block, size, 0);
    stp_large_blocks_close(&large);
}

// Memory in use and kept blocks share one limit.
typedef struct held {
    stp_context* context;
    int failed[4];
} held;

static void allocate_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    held* h = user;
    for (size_t i = begin; i < end; ++i) {
        size_t size = (i * 37 % 11 + 1) * 300 * KILOBYTE;
        unsigned char* a = stp_alloc(h->context, size);
        unsigned char* b = stp_alloc(h->context, size / 3);
        if (a == NULL || b == NULL) {
            h->failed[worker] += 1;
        } else {
            memset(a, 1, size);
            memset(b, 2, size / 3);
        }
        stp_free(h->context, a);
        stp_free(h->context, b);
    }
}

void test_contexts_keep_freed_blocks_within_their_limit(test_state* test)
{
    const size_t limit = 8 * MEGABYTE;
    stp_context_desc desc = {.thread_count = 1, .memory_limit_bytes = limit};
    stp_context* context = NULL;
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    held h = {.context = context};
    for (size_t i = 0; i < 60; ++i) {
        allocate_some(i, i + 1, 0, &h);
        size_t live = (size_t)stp_context_live_bytes(context);
        CHECK(live + context->large_blocks.kept_bytes <= limit);
        void* maximum = stp_alloc(context, limit - live - KILOBYTE); // kept blocks give way
        CHECK(maximum != NULL);
        CHECK(context->large_blocks.kept_bytes <= KILOBYTE);
        stp_free(context, maximum);
    }
    CHECK_EQUAL(0, h.failed[0]);
    stp_context_destroy(context);

    desc = (stp_context_desc){.thread_count = 3, .memory_limit_bytes = 4 * limit};
    CHECK_EQUAL(STP_OK, stp_context_create(&context, &desc));
    h = (held){.context = context};
    stp_parallel_for(context, 120, 1, allocate_some, &h);
    CHECK_EQUAL(0, h.failed[0] + h.failed[1] + h.failed[2]);
    CHECK(stp_context_live_bytes(context) + context->large_blocks.kept_bytes <= 4 * limit);
    stp_context_destroy(context);
}
