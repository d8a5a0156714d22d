// SPDX-License-Identifier: MIT
//
// Suballocator for the words of a few large buffers. Independent of OpenGL: an address is a number,
// a buffer is a range of addresses.
//
// Free spans are kept in lists by size, eight per power of two, with one bit per non-empty list;
// free neighbours are merged (two-level segregated fit: Masmano et al. 2004). Allocating and
// freeing take constant time; only if nothing larger is free, a whole list is searched.
#pragma once

#include "base/core/context.h"

enum {
    SPANS_UNIT = 4, ///< words: sizes and addresses are multiples of it
    SPANS_SUBLISTS = 8,
    SPANS_LISTS = 32 * SPANS_SUBLISTS,
};

#define SPANS_NONE UINT32_MAX

typedef struct stp_gl_span {
    uint32_t first, count;
    uint32_t before, after;  ///< the neighbours in the region
    uint32_t previous, next; ///< in the free list; unused entries use `next` only
    bool is_free;
} stp_gl_span;

/// Zero-initialize all but the context.
typedef struct stp_gl_spans {
    stp_context* context;
    stp_gl_span* spans;
    size_t count, capacity;
    uint32_t unused;             ///< list of unused entries, from 1; 0: none
    uint32_t heads[SPANS_LISTS]; ///< entries, from 1; 0: none
    uint32_t classes;            ///< one bit per power of two: whether a list is not empty
    uint8_t sublists[32];
    uint64_t used, total; ///< words
} stp_gl_spans;

void stp_gl_spans_destroy(stp_gl_spans* spans);

/// Adds words [first, first + count); spans never cross regions. Both are multiples of the unit.
/// @return false if out of memory
STP_MUST_USE bool stp_gl_spans_add_region(stp_gl_spans* spans, uint32_t first, uint32_t count);

/// Allocates a span of at least `count` words, above 0. Succeeds if any free span is large enough.
/// @return the span; SPANS_NONE if there is no space, or out of memory
uint32_t stp_gl_spans_take(stp_gl_spans* spans, uint32_t count);
void stp_gl_spans_release(stp_gl_spans* spans, uint32_t span);

static inline uint32_t stp_gl_spans_first(const stp_gl_spans* spans, uint32_t span)
{
    return spans->spans[span].first;
}

/// Size in words, possibly more than requested.
static inline uint32_t stp_gl_spans_count(const stp_gl_spans* spans, uint32_t span)
{
    return spans->spans[span].count;
}

/// Size in words of a span for a request.
static inline uint64_t stp_gl_spans_round(uint64_t count)
{
    return (count + SPANS_UNIT - 1) / SPANS_UNIT * SPANS_UNIT;
}
