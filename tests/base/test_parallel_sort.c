// SPDX-License-Identifier: MIT
// The multi-threaded radix sort (src/base/core/sort.h) against the single-threaded one.
#include "tests.h"

#include "base/core/sort.h"
#include "base/math/rng.h"

#include <stdlib.h>
#include <string.h>

enum { ITEMS = 300000 };

static void fill(uint64_t* items, size_t count)
{
    for (size_t i = 0; i < count; ++i) {
        uint64_t key = stp_rng_hash(count, i) >> (i % 3 == 0 ? 60 : 30); // many are equal
        items[i] = key << 32 | i;
    }
}

void test_parallel_sort_agrees_with_the_serial_one(test_state* test)
{
    static const size_t counts[] = {0, 1, 65535, 65536, 65537, ITEMS};
    static const unsigned bits[] = {32, 30, 7, 12};
    uint64_t* arrays[4];
    for (int i = 0; i < 4; ++i) {
        arrays[i] = malloc(ITEMS * sizeof(uint64_t));
        CHECK(arrays[i] != NULL);
    }
    stp_context* context = test_context(NULL, 3, NULL);
    for (size_t c = 0; c < sizeof(counts) / sizeof(counts[0]); ++c) {
        for (size_t b = 0; b < sizeof(bits) / sizeof(bits[0]); ++b) {
            fill(arrays[0], counts[c]);
            fill(arrays[2], counts[c]);
            uint64_t* serial = stp_sort_u64(arrays[0], arrays[1], counts[c], 32, bits[b]);
            uint64_t* parallel =
                stp_parallel_sort_u64(context, arrays[2], arrays[3], counts[c], 32, bits[b]);
            CHECK(parallel == arrays[2] || parallel == arrays[3]);
            CHECK(memcmp(serial, parallel, counts[c] * sizeof(uint64_t)) == 0);
        }
    }
    stp_context_destroy(context);
    for (int i = 0; i < 4; ++i) {
        free(arrays[i]);
    }
}

void test_parallel_sort_reports_lack_of_memory(test_state* test)
{
    uint64_t *items = calloc(ITEMS, sizeof(uint64_t)), *scratch = calloc(ITEMS, sizeof(uint64_t));
    test_heap heap = TEST_HEAP(-1);
    stp_context* context = test_context(&heap, 2, NULL);
    CHECK(items != NULL && scratch != NULL && context != NULL);
    heap.fail_at = heap.count;
    CHECK(stp_parallel_sort_u64(context, items, scratch, ITEMS, 32, 32) == NULL);
    heap.fail_at = -1;
    CHECK(stp_parallel_sort_u64(context, items, scratch, ITEMS, 32, 32) != NULL);
    stp_context_destroy(context);
    CHECK_EQUAL(0, heap.live_bytes);
    free(items);
    free(scratch);
}
