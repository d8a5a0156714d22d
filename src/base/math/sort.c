// SPDX-License-Identifier: MIT
#include "base/math/sort.h"

#include <assert.h>
#include <string.h>

#define DIGIT_BITS 11u
#define DIGIT_COUNT (1u << DIGIT_BITS)

#ifndef NDEBUG
static int is_sorted(const uint64_t* items, size_t count, unsigned first_bit, unsigned bit_count)
{
    uint64_t mask = bit_count < 64 ? ((uint64_t)1 << bit_count) - 1 : UINT64_MAX;
    int sorted = 1;
    for (size_t i = 1; i < count && bit_count > 0; ++i) {
        sorted = sorted && (items[i - 1] >> first_bit & mask) <= (items[i] >> first_bit & mask);
    }
    return sorted;
}
#endif

uint64_t* stp_sort_u64(uint64_t* items, uint64_t* scratch, size_t count, unsigned first_bit,
                       unsigned bit_count)
{
    assert(first_bit + bit_count <= 64);
    assert((count == 0 || items != scratch) && "two arrays");
    for (unsigned done = 0; done < bit_count; done += DIGIT_BITS) {
        unsigned left = bit_count - done, shift = first_bit + done;
        uint64_t mask = left < DIGIT_BITS ? ((uint64_t)1 << left) - 1 : DIGIT_COUNT - 1;
        size_t starts[DIGIT_COUNT];
        memset(starts, 0, sizeof(starts));
        for (size_t i = 0; i < count; ++i) {
            starts[(items[i] >> shift) & mask] += 1;
        }
        size_t sum = 0;
        for (size_t digit = 0; digit <= mask; ++digit) {
            size_t size = starts[digit];
            starts[digit] = sum;
            sum += size;
        }
        assert(sum == count && "each item has one digit");
        for (size_t i = 0; i < count; ++i) {
            scratch[starts[(items[i] >> shift) & mask]++] = items[i];
        }
        uint64_t* swap = items;
        items = scratch;
        scratch = swap;
    }
    assert(is_sorted(items, count, first_bit, bit_count));
    return items;
}
