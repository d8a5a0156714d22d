// SPDX-License-Identifier: MIT
// Suballocation of large regions, against a map of every word.
#include "tests.h"

#include "base/math/rng.h"
#include "draw/gl/spans.h"

#include <string.h>

enum { WORDS = 4096, REGIONS = 3, KEPT = 200, STEPS = 20000 };

typedef struct shared {
    stp_gl_spans spans;
    uint8_t taken[REGIONS][WORDS]; ///< each word: whether it is in use
    uint32_t kept[KEPT], asked[KEPT];
    uint32_t count;
} shared;

static const uint32_t region_firsts[REGIONS] = {0, 1u << 20, 1u << 28};

static uint8_t* words_at(shared* s, uint32_t first, uint32_t count)
{
    for (int i = 0; i < REGIONS; ++i) {
        if (first >= region_firsts[i] &&
            (uint64_t)first + count <= region_firsts[i] + (uint64_t)WORDS) {
            return s->taken[i] + (first - region_firsts[i]);
        }
    }
    return NULL; // outside a region, or across its end
}

static bool has_room(const shared* s, uint32_t count)
{
    for (int i = 0; i < REGIONS; ++i) {
        uint32_t run = 0;
        for (uint32_t w = 0; w < WORDS; ++w) {
            run = s->taken[i][w] ? 0 : run + 1;
            if (run >= count) {
                return true;
            }
        }
    }
    return false;
}

static bool is_all(const uint8_t* words, uint32_t count, uint8_t value)
{
    bool all = true;
    for (uint32_t i = 0; i < count; ++i) {
        all = all && words[i] == value;
    }
    return all;
}

static void take_one(test_state* test, shared* s, uint32_t asked)
{
    uint32_t rounded = (uint32_t)stp_gl_spans_round(asked);
    bool room = has_room(s, rounded);
    uint32_t span = stp_gl_spans_take(&s->spans, asked);
    CHECK(room == (span != SPANS_NONE));
    if (!room) {
        return;
    }
    uint32_t first = stp_gl_spans_first(&s->spans, span),
             count = stp_gl_spans_count(&s->spans, span);
    uint8_t* words = words_at(s, first, count);
    CHECK_EQUAL(rounded, count);
    CHECK(first % SPANS_UNIT == 0 && words != NULL);
    CHECK(is_all(words, count, 0));
    memset(words, 1, count);
    s->kept[s->count++] = span;
}

static void give_one(test_state* test, shared* s, uint32_t at)
{
    uint32_t span = s->kept[at], count = stp_gl_spans_count(&s->spans, span);
    uint8_t* words = words_at(s, stp_gl_spans_first(&s->spans, span), count);
    CHECK(words != NULL && is_all(words, count, 1));
    memset(words, 0, count);
    stp_gl_spans_release(&s->spans, span);
    s->kept[at] = s->kept[--s->count];
}

void test_gl_spans_are_those_of_a_map(test_state* test)
{
    static shared s;
    s = (shared){.spans.context = test_context(NULL, 1, NULL)};
    for (int i = 0; i < REGIONS; ++i) {
        CHECK(stp_gl_spans_add_region(&s.spans, region_firsts[i], WORDS));
    }
    for (uint32_t step = 0; step < STEPS; ++step) {
        uint64_t bits = stp_rng_hash(7, step);
        // phases of mostly allocations and mostly releases; sizes of all powers of two
        bool takes = stp_rng_below(8, step, 100) < (step / 500 % 2 != 0 ? 35u : 65u);
        if (s.count == 0 || (takes && s.count < KEPT)) {
            take_one(test, &s, 1 + (uint32_t)(bits >> 20) % (1u << (bits % 13)));
        } else {
            give_one(test, &s, (uint32_t)(bits >> 32) % s.count);
        }
        uint64_t used = 0;
        for (uint32_t i = 0; i < s.count; ++i) {
            used += stp_gl_spans_count(&s.spans, s.kept[i]);
        }
        CHECK_EQUAL(used, s.spans.used);
    }
    while (s.count > 0) {
        give_one(test, &s, s.count / 2);
    }
    for (int i = 0; i < REGIONS; ++i) { // all neighbours are joined again
        CHECK(stp_gl_spans_take(&s.spans, WORDS) != SPANS_NONE);
    }
    CHECK_EQUAL(SPANS_NONE, stp_gl_spans_take(&s.spans, 1));
    stp_gl_spans_destroy(&s.spans);
    stp_context_destroy(s.spans.context);
}

void test_gl_spans_survive_failing_memory(test_state* test)
{
    for (int fail = 0; fail < 40; ++fail) {
        test_heap heap = TEST_HEAP(-1);
        stp_gl_spans spans = {.context = test_context(&heap, 1, NULL)};
        uint32_t kept[64], count = 0;
        heap.fail_at = heap.count + fail;
        bool added = stp_gl_spans_add_region(&spans, 0, 1u << 16);
        for (uint32_t i = 0; i < 64 && added; ++i) {
            uint32_t span = stp_gl_spans_take(&spans, 16 * (i + 1));
            if (span != SPANS_NONE) {
                kept[count++] = span;
            }
        }
        for (uint32_t i = 0; i < count; ++i) {
            stp_gl_spans_release(&spans, kept[i]);
        }
        CHECK_EQUAL(0, spans.used);
        CHECK(!added || stp_gl_spans_take(&spans, 1u << 16) != SPANS_NONE);
        stp_gl_spans_destroy(&spans);
        stp_context_destroy(spans.context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
}

void test_gl_spans_refuse_invalid_sizes(test_state* test)
{
    stp_gl_spans spans = {.context = test_context(NULL, 1, NULL)};
    CHECK(stp_gl_spans_add_region(&spans, 0, 1u << 10));
    CHECK_EQUAL(SPANS_NONE, stp_gl_spans_take(&spans, 0));
    CHECK_EQUAL(SPANS_NONE, stp_gl_spans_take(&spans, UINT32_MAX));
    CHECK_EQUAL(SPANS_NONE, stp_gl_spans_take(&spans, (1u << 10) + 1));
    stp_gl_spans_destroy(&spans);
    stp_context_destroy(spans.context);
}
