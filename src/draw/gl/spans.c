// SPDX-License-Identifier: MIT
#include "draw/gl/spans.h"

#include <assert.h>

void stp_gl_spans_destroy(stp_gl_spans* spans)
{
    stp_free(spans->context, spans->spans);
    *spans = (stp_gl_spans){.context = spans->context};
}

/// List of free spans for a size.
static uint32_t list_of(uint32_t count)
{
    assert(count > 0 && "empty spans do not exist");
    uint32_t high = 31u - (uint32_t)__builtin_clz(count);
    uint32_t low = high >= 3 ? count >> (high - 3) & 7u : 0;
    return high * SPANS_SUBLISTS + low;
}

/// Takes an unused entry. @return SPANS_NONE if out of memory
static uint32_t make_entry(stp_gl_spans* s)
{
    if (s->unused != 0) {
        uint32_t entry = s->unused - 1;
        s->unused = s->spans[entry].next;
        return entry;
    }
    if (s->count == s->capacity) {
        if (!STP_MAKE_ROOM(s->context, s->spans, s->capacity, s->count + 1)) {
            return SPANS_NONE;
        }
    }
    return (uint32_t)s->count++;
}

static void drop_entry(stp_gl_spans* s, uint32_t entry)
{
    s->spans[entry].next = s->unused;
    s->unused = entry + 1;
}

static void put_in_list(stp_gl_spans* s, uint32_t entry)
{
    stp_gl_span* span = &s->spans[entry];
    assert(!span->is_free && "in one list at most");
    uint32_t list = list_of(span->count);
    span->is_free = true;
    span->previous = SPANS_NONE;
    span->next = s->heads[list] != 0 ? s->heads[list] - 1 : SPANS_NONE;
    if (span->next != SPANS_NONE) {
        s->spans[span->next].previous = entry;
    }
    s->heads[list] = entry + 1;
    s->classes |= 1u << (list / SPANS_SUBLISTS);
    s->sublists[list / SPANS_SUBLISTS] |= (uint8_t)(1u << (list % SPANS_SUBLISTS));
}

static void take_from_list(stp_gl_spans* s, uint32_t entry)
{
    stp_gl_span* span = &s->spans[entry];
    uint32_t list = list_of(span->count), doubling = list / SPANS_SUBLISTS;
    assert(span->is_free && s->heads[list] != 0 && "it is in the list of its size");
    span->is_free = false;
    if (span->previous != SPANS_NONE) {
        s->spans[span->previous].next = span->next;
    } else {
        s->heads[list] = span->next != SPANS_NONE ? span->next + 1 : 0;
    }
    if (span->next != SPANS_NONE) {
        s->spans[span->next].previous = span->previous;
    }
    if (s->heads[list] == 0) {
        s->sublists[doubling] &= (uint8_t) ~(1u << (list % SPANS_SUBLISTS));
        s->classes &= s->sublists[doubling] == 0 ? ~(1u << doubling) : UINT32_MAX;
    }
}

bool stp_gl_spans_add_region(stp_gl_spans* spans, uint32_t first, uint32_t count)
{
    assert(first % SPANS_UNIT == 0 && count % SPANS_UNIT == 0 && count > 0);
    uint32_t entry = make_entry(spans);
    if (entry == SPANS_NONE) {
        return false;
    }
    spans->spans[entry] =
        (stp_gl_span){.first = first, .count = count, .before = SPANS_NONE, .after = SPANS_NONE};
    put_in_list(spans, entry);
    spans->total += count;
    return true;
}

/// A free span of a list above `list`: every span there is larger than all spans of `list`.
static uint32_t find_beyond(const stp_gl_spans* s, uint32_t list)
{
    uint32_t doubling = list / SPANS_SUBLISTS, within = list % SPANS_SUBLISTS;
    uint32_t sublists = s->sublists[doubling] & ~((2u << within) - 1u);
    if (sublists == 0) {
        uint32_t classes = doubling < 31 ? s->classes & ~((2u << doubling) - 1u) : 0;
        if (classes == 0) {
            return SPANS_NONE;
        }
        doubling = (uint32_t)__builtin_ctz(classes);
        sublists = s->sublists[doubling];
    }
    return s->heads[doubling * SPANS_SUBLISTS + (uint32_t)__builtin_ctz(sublists)] - 1;
}

static uint32_t find_free(const stp_gl_spans* s, uint32_t count)
{
    uint32_t list = list_of(count);
    uint32_t head = s->heads[list];
    if (head != 0 && s->spans[head - 1].count >= count) {
        return head - 1;
    }
    uint32_t found = find_beyond(s, list);
    // search the same list only as a last resort
    for (uint32_t at = head != 0 ? head - 1 : SPANS_NONE; found == SPANS_NONE && at != SPANS_NONE;
         at = s->spans[at].next) {
        found = s->spans[at].count >= count ? at : SPANS_NONE;
    }
    assert(found == SPANS_NONE || (s->spans[found].is_free && s->spans[found].count >= count));
    return found;
}

uint32_t stp_gl_spans_take(stp_gl_spans* spans, uint32_t count)
{
    uint64_t rounded = stp_gl_spans_round(count);
    if (count == 0 || rounded > UINT32_MAX) {
        return SPANS_NONE;
    }
    count = (uint32_t)rounded;
    uint32_t found = find_free(spans, count);
    if (found == SPANS_NONE) {
        return SPANS_NONE;
    }
    if (spans->spans[found].count > count) {
        uint32_t rest = make_entry(spans);
        if (rest == SPANS_NONE) {
            return SPANS_NONE;
        }
        take_from_list(spans, found);
        stp_gl_span* span = &spans->spans[found];
        spans->spans[rest] = (stp_gl_span){.first = span->first + count,
                                           .count = span->count - count,
                                           .before = found,
                                           .after = span->after};
        if (span->after != SPANS_NONE) {
            spans->spans[span->after].before = rest;
        }
        span->after = rest;
        span->count = count;
        put_in_list(spans, rest);
    } else {
        take_from_list(spans, found);
    }
    spans->used += count;
    assert(spans->used <= spans->total && !spans->spans[found].is_free);
    assert(spans->spans[found].count == count && "the rest is free");
    return found;
}

/// Merges two neighbouring spans; removes `second`.
static void join(stp_gl_spans* s, uint32_t first, uint32_t second)
{
    stp_gl_span *a = &s->spans[first], *b = &s->spans[second];
    assert(a->after == second && b->before == first && a->first + a->count == b->first);
    a->count += b->count;
    a->after = b->after;
    if (b->after != SPANS_NONE) {
        s->spans[b->after].before = first;
    }
    drop_entry(s, second);
}

void stp_gl_spans_release(stp_gl_spans* spans, uint32_t span)
{
    stp_gl_span* given = &spans->spans[span];
    assert(!given->is_free && "given back twice");
    assert(given->count <= spans->used);
    spans->used -= given->count;
    uint32_t before = given->before, after = given->after;
    if (after != SPANS_NONE && spans->spans[after].is_free) {
        take_from_list(spans, after);
        join(spans, span, after);
    }
    if (before != SPANS_NONE && spans->spans[before].is_free) {
        take_from_list(spans, before);
        join(spans, before, span);
        span = before;
    }
    put_in_list(spans, span);
}
