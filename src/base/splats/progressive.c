// SPDX-License-Identifier: MIT
#include "base/splats/progressive.h"

#include "base/splats/splat_codes.h"

#include <assert.h>
#include <string.h>

enum { DIGITS = 256 }; ///< values of one byte of a code

static uint32_t lowest_of(const uint32_t* ranges, uint32_t splat)
{
    return ranges[splat] & 0xFFFFu;
}

stp_progressive_counts stp_progressive_count(const uint32_t* ranges, uint32_t count)
{
    stp_progressive_counts c = {0};
    while (c.base < count && ranges[c.base] >> 16 >= STP_RANGE_INFINITE) {
        c.base += 1;
    }
    c.splits = (count - c.base) / 2;
    for (uint32_t i = 0; i < count; ++i) {
        c.parents += lowest_of(ranges, i) != 0 ? 1 : 0;
    }
    return c;
}

/// Sorts indices by one byte of their lowest levels, highest first. Stable.
static void sort_digit(const uint32_t* ranges, const uint32_t* from, uint32_t count, uint32_t shift,
                       uint32_t* to)
{
    uint32_t places[DIGITS + 1] = {0};
    for (uint32_t i = 0; i < count; ++i) {
        places[DIGITS - (ranges[from[i]] >> shift & 0xFFu)] += 1;
    }
    for (uint32_t d = 1; d <= DIGITS; ++d) { // places[0] is 0
        places[d] += places[d - 1];
    }
    for (uint32_t i = 0; i < count; ++i) {
        to[places[DIGITS - 1 - (ranges[from[i]] >> shift & 0xFFu)]++] = from[i];
    }
}

#ifndef NDEBUG
static bool is_order(const uint32_t* ranges, const uint32_t* order, uint32_t count)
{
    bool ordered = true;
    for (uint32_t i = 1; i < count; ++i) {
        uint32_t before = lowest_of(ranges, order[i - 1]), here = lowest_of(ranges, order[i]);
        ordered = ordered && (before > here || (before == here && order[i - 1] < order[i]));
    }
    return ordered;
}
#endif

uint32_t stp_progressive_order(const uint32_t* ranges, uint32_t count, uint32_t* order,
                               uint32_t* scratch)
{
    assert((count == 0 || order != scratch) && "two arrays");
    uint32_t parents = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (lowest_of(ranges, i) != 0) {
            order[parents++] = i;
        }
    }
    sort_digit(ranges, order, parents, 0, scratch);
    sort_digit(ranges, scratch, parents, 8, order);
    assert(is_order(ranges, order, parents) && "by descending level, ties by index");
    return parents;
}

bool stp_progressive_fits(uint32_t parent, uint32_t child)
{
    uint32_t level = parent & 0xFFFFu, highest = child >> 16;
    return (child & 0xFFFFu) <= level && level <= highest && highest < STP_RANGE_INFINITE;
}

bool stp_progressive_is_valid(const uint32_t* ranges, uint32_t count, const uint32_t* order)
{
    stp_progressive_counts c = stp_progressive_count(ranges, count);
    if (c.base == 0 || c.parents < (count - c.base + 1) / 2) {
        return count == 0;
    }
    for (uint32_t i = 0; i < c.base; ++i) {
        if (!stp_range_is_valid(ranges[i])) {
            return false;
        }
    }
    for (uint32_t i = c.base; i < count; ++i) {
        uint32_t split = (i - c.base) / 2, parent = order[split];
        if (parent >= c.base + 2 * split || !stp_progressive_fits(ranges[parent], ranges[i])) {
            return false;
        }
    }
    return true;
}

bool stp_progressive_is_whole(const uint32_t* ranges, uint32_t count, const uint32_t* order)
{
    stp_progressive_counts c = stp_progressive_count(ranges, count);
    return c.parents == c.splits && count == c.base + 2 * c.splits &&
           stp_progressive_is_valid(ranges, count, order);
}

/// Finds the byte of the code of parent number `*rank`, among the codes with `above` in the bits
/// over that byte. `*rank` becomes its rank among those with the same byte.
static uint32_t find_digit(const uint32_t* ranges, uint32_t count, uint32_t shift, uint32_t above,
                           uint32_t* rank)
{
    uint32_t sizes[DIGITS] = {0}, digit = DIGITS - 1;
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t low = lowest_of(ranges, i);
        sizes[low >> shift & 0xFFu] += low != 0 && low >> shift >> 8 == above ? 1 : 0;
    }
    for (; digit > 0 && *rank >= sizes[digit]; --digit) {
        *rank -= sizes[digit];
    }
    return digit;
}

stp_progressive_cut stp_progressive_find_cut(const uint32_t* ranges, uint32_t count,
                                             uint32_t wanted)
{
    stp_progressive_counts c = stp_progressive_count(ranges, count);
    uint32_t split = wanted > c.base ? wanted - c.base : 0;
    split = split < c.splits ? split : c.splits;
    stp_progressive_cut cut = {.end = c.base + 2 * split, .splats = c.base + split};
    if (split >= c.parents) {
        return cut;
    }
    uint32_t rank = split;
    uint32_t upper = find_digit(ranges, count, 8, 0, &rank);
    cut.code = upper << 8 | find_digit(ranges, count, 0, upper, &rank);
    for (uint32_t i = 0; i < count; ++i) {
        if (lowest_of(ranges, i) == cut.code && rank-- == 0) {
            cut.divide = i;
            break;
        }
    }
    assert(cut.end <= count && cut.splats <= cut.end);
    assert(cut.code != 0 && lowest_of(ranges, cut.divide) == cut.code && "the next parent");
    uint32_t bits = cut.code << 15;
    cut.level = stp_float_of_bits(bits);
    cut.below = stp_float_of_bits(bits - 1);
    return cut;
}

static bool is_before(const uint32_t* ranges, uint32_t a, uint32_t b)
{
    uint32_t x = lowest_of(ranges, a), y = lowest_of(ranges, b);
    return x != y ? x > y : a < b;
}

void stp_progressive_queue_add(stp_progressive_queue* q, uint32_t splat)
{
    if (lowest_of(q->ranges, splat) == 0) {
        return;
    }
    uint32_t at = q->count++;
    while (at > 0 && is_before(q->ranges, splat, q->heap[(at - 1) / 2])) {
        q->heap[at] = q->heap[(at - 1) / 2];
        at = (at - 1) / 2;
    }
    q->heap[at] = splat;
}

uint32_t stp_progressive_queue_take(stp_progressive_queue* q)
{
    if (q->count == 0) {
        return UINT32_MAX;
    }
    uint32_t first = q->heap[0], last = q->heap[--q->count], at = 0;
    for (uint32_t child = 1; child < q->count; child = 2 * at + 1) {
        if (child + 1 < q->count && is_before(q->ranges, q->heap[child + 1], q->heap[child])) {
            child += 1;
        }
        if (!is_before(q->ranges, q->heap[child], last)) {
            break;
        }
        q->heap[at] = q->heap[child];
        at = child;
    }
    q->heap[at] = last;
    assert((q->count == 0 || is_before(q->ranges, first, q->heap[0])) && "in split order");
    return first;
}

stp_progressive_queue stp_progressive_queue_begin(const uint32_t* ranges, uint32_t count,
                                                  uint32_t done, uint32_t* heap)
{
    stp_progressive_queue q = {.ranges = ranges, .heap = heap};
    uint32_t base = stp_progressive_count(ranges, count).base;
    assert(done <= count - base && "splits of the prefix");
    stp_progressive_cut cut = stp_progressive_find_cut(ranges, count, base + done);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t low = lowest_of(ranges, i);
        if (low < cut.code || (low == cut.code && i >= cut.divide)) {
            stp_progressive_queue_add(&q, i);
        }
    }
    return q;
}
