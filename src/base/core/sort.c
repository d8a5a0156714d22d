// SPDX-License-Identifier: MIT
#include "base/core/sort.h"

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

enum {
    LEAST = 1 << 16, ///< fewer items are sorted on one thread
    MAX_TASKS = 64,  ///< each has its own digit counts
};

typedef struct sorter {
    const uint64_t* from;
    uint64_t* to;
    size_t count, task_size;
    unsigned shift;
    uint64_t mask;
    size_t (*starts)[DIGIT_COUNT]; ///< per task: items per digit, then their target index
} sorter;

static size_t end_of_task(const sorter* s, size_t task)
{
    size_t end = (task + 1) * s->task_size;
    return end < s->count ? end : s->count;
}

static void count_digits(size_t begin, size_t end, uint32_t worker, void* user)
{
    const sorter* s = user;
    (void)worker;
    for (size_t task = begin; task < end; ++task) {
        size_t* counts = s->starts[task];
        memset(counts, 0, sizeof(s->starts[task]));
        for (size_t i = task * s->task_size; i < end_of_task(s, task); ++i) {
            counts[(s->from[i] >> s->shift) & s->mask] += 1;
        }
    }
}

static void move_items(size_t begin, size_t end, uint32_t worker, void* user)
{
    const sorter* s = user;
    (void)worker;
    for (size_t task = begin; task < end; ++task) {
        size_t* starts = s->starts[task];
        for (size_t i = task * s->task_size; i < end_of_task(s, task); ++i) {
            s->to[starts[(s->from[i] >> s->shift) & s->mask]++] = s->from[i];
        }
    }
}

/// Turns counts into places. For equal digits, earlier tasks come first, so the sort is stable.
static void find_starts(const sorter* s, size_t tasks)
{
    size_t sum = 0;
    for (size_t digit = 0; digit <= s->mask; ++digit) {
        for (size_t task = 0; task < tasks; ++task) {
            size_t size = s->starts[task][digit];
            s->starts[task][digit] = sum;
            sum += size;
        }
    }
    assert(sum == s->count && "each item has one digit");
}

uint64_t* stp_parallel_sort_u64(stp_context* context, uint64_t* items, uint64_t* scratch,
                                size_t count, unsigned first_bit, unsigned bit_count)
{
    assert(first_bit + bit_count <= 64);
    if (count < LEAST) {
        return stp_sort_u64(items, scratch, count, first_bit, bit_count);
    }
    sorter s = {.count = count, .task_size = LEAST / 2};
    while (s.task_size * MAX_TASKS < count) {
        s.task_size *= 2;
    }
    size_t tasks = (count + s.task_size - 1) / s.task_size;
    assert(tasks <= MAX_TASKS && end_of_task(&s, tasks - 1) == count && "tasks cover all");
    s.starts = stp_alloc(context, tasks * sizeof(*s.starts));
    if (s.starts == NULL) {
        return NULL;
    }
    for (unsigned done = 0; done < bit_count; done += DIGIT_BITS) {
        unsigned left = bit_count - done;
        s.shift = first_bit + done;
        s.mask = left < DIGIT_BITS ? ((uint64_t)1 << left) - 1 : DIGIT_COUNT - 1;
        s.from = items;
        s.to = scratch;
        stp_parallel_for(context, tasks, 1, count_digits, &s);
        find_starts(&s, tasks);
        stp_parallel_for(context, tasks, 1, move_items, &s);
        uint64_t* swap = items;
        items = scratch;
        scratch = swap;
    }
    stp_free(context, s.starts);
    return items;
}
