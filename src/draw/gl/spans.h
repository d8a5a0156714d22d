// SPDX-License-Identifier: MIT
//
// Shares out the words of a few large buffers. Knows no OpenGL: an address is a number, a buffer is a region of them.
//
// Free spans stand in lists by size, eight to each doubling, with a bit for each list that is not empty; neighbours that
// are free become one (two-level segregated fit: Masmano et al. 2004). Taking and giving back take about the same time
// however many spans there are.
#pragma once

#include "base/context.h"

enum {
    SPANS_UNIT = 4, ///< words: sizes and addresses are multiples of it
    SPANS_SUBLISTS = 8,
    SPANS_LISTS = 32 * SPANS_SUBLISTS,
};

#define SPANS_NONE UINT32_MAX

typedef struct gl_span {
    uint32_t first, count;
    uint32_t before, after;  ///< the neighbours in the region
    uint32_t previous, next; ///< in the list of free ones; of unused entries `next` alone
    bool is_free;
} gl_span;

/// All zero but for the context at first.
typedef struct gl_spans {
    stp_context* context;
    gl_span* spans;
    size_t count, capacity;
    uint32_t unused;             ///< entries that stand for nothing, from 1 on; 0: none
    uint32_t heads[SPANS_LISTS]; ///< entries, from 1 on; 0: none
    uint32_t classes;            ///< a bit a doubling that has any
    uint8_t sublists[32];
    uint64_t used, total; ///< words
} gl_spans;

void gl_spans_destroy(gl_spans* spans);

/// Adds words [first, first + count) to share out; spans never reach from one region into another. Both are multiples of
/// the unit. @return false where memory runs out
STP_MUST_USE bool gl_spans_add_region(gl_spans* spans, uint32_t first, uint32_t count);

/// Takes a span of at least `count` words, above 0. It is found wherever a free span is large enough.
/// @return the span, SPANS_NONE where there is none or memory runs out
uint32_t gl_spans_take(gl_spans* spans, uint32_t count);
void gl_spans_give_back(gl_spans* spans, uint32_t span);

static inline uint32_t gl_spans_first(const gl_spans* spans, uint32_t span)
{
    return spans->spans[span].first;
}

/// Words that it takes, some more than were asked for.
static inline uint32_t gl_spans_count(const gl_spans* spans, uint32_t span)
{
    return spans->spans[span].count;
}

/// The words that a span for so many takes.
static inline uint64_t gl_spans_round(uint64_t count)
{
    return (count + SPANS_UNIT - 1) / SPANS_UNIT * SPANS_UNIT;
}
