// SPDX-License-Identifier: MIT
// The order of progressive sets, and cuts at any count.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "store/support_progressive.h"

#include <stdlib.h>
#include <string.h>

enum { MOST = 700 };

typedef struct fixture {
    stp_context* context;
    stp_arena arena;
    stp_splats set;
    stp_progressive_counts counts;
    uint32_t order[MOST], scratch[MOST];
} fixture;

static const progressive_desc samples[] = {
    {.seed = 1, .base = 1, .splits = 0},
    {.seed = 2, .base = 1, .splits = 1},
    {.seed = 3, .base = 1, .splits = 200},
    {.seed = 4, .base = 7, .splits = 300},
    {.seed = 5, .base = 7, .splits = 300, .coarse = true},
    {.seed = 6, .base = 90, .splits = 3},
    {.seed = 7, .base = 40, .splits = 250, .wild = true},
    {.seed = 8, .base = 600, .splits = 0},
};
enum { SAMPLES = sizeof(samples) / sizeof(samples[0]) };

static bool set_up(fixture* f, size_t sample)
{
    f->context = test_context(NULL, 1, NULL);
    f->arena = stp_arena_create(f->context, 1 << 20);
    bool made = progressive_sample_make(&f->arena, &samples[sample], &f->set);
    f->counts = stp_progressive_count(f->set.ranges, f->set.count);
    stp_progressive_order(f->set.ranges, f->set.count, f->order, f->scratch);
    return made;
}

static void tear_down(fixture* f)
{
    stp_arena_destroy(&f->arena);
    stp_context_destroy(f->context);
}

void test_progressive_order_is_that_of_levels(test_state* test)
{
    for (size_t n = 0; n < SAMPLES; ++n) {
        fixture f;
        CHECK(set_up(&f, n));
        CHECK_EQUAL(samples[n].base, f.counts.base);
        CHECK_EQUAL(samples[n].splits, f.counts.splits);
        CHECK_EQUAL(samples[n].splits, f.counts.parents);
        CHECK(stp_progressive_is_whole(f.set.ranges, f.set.count, f.order));
        for (uint32_t s = 1; s < f.counts.parents; ++s) {
            uint32_t a = f.order[s - 1], b = f.order[s];
            uint32_t x = f.set.ranges[a] & 0xFFFFu, y = f.set.ranges[b] & 0xFFFFu;
            CHECK(y > 0 && (x > y || (x == y && a < b)));
        }
        // a reader of any prefix finds the same parents
        for (uint32_t count = 0; count <= f.set.count; count += 1 + count / 16) {
            uint32_t order[MOST], scratch[MOST];
            stp_progressive_counts c = stp_progressive_count(f.set.ranges, count);
            stp_progressive_order(f.set.ranges, count, order, scratch);
            CHECK(memcmp(order, f.order, c.splits * sizeof(*order)) == 0);
            CHECK(stp_progressive_is_valid(f.set.ranges, count, order));
        }
        tear_down(&f);
    }
}

// A reader's queue gives the same parents from any start.
void test_progressive_queue_gives_the_same_parents(test_state* test)
{
    for (size_t n = 0; n < SAMPLES; ++n) {
        fixture f;
        CHECK(set_up(&f, n));
        uint32_t base = f.counts.base;
        for (uint32_t done = 0; done <= f.counts.splits; done += 1 + done / 8) {
            uint32_t room[MOST];
            stp_progressive_queue q =
                stp_progressive_queue_begin(f.set.ranges, base + 2 * done, done, room);
            for (uint32_t s = done; s < f.counts.splits; ++s) {
                CHECK_EQUAL(f.order[s], stp_progressive_queue_take(&q));
                stp_progressive_queue_add(&q, base + 2 * s);
                stp_progressive_queue_add(&q, base + 2 * s + 1);
            }
            CHECK_EQUAL(UINT32_MAX, stp_progressive_queue_take(&q));
        }
        tear_down(&f);
    }
}

void test_progressive_damage_is_found(test_state* test)
{
    fixture f;
    CHECK(set_up(&f, 3));
    uint32_t count = f.set.count, last = count - 1, *ranges = f.set.ranges, kept;
    uint32_t* order = f.order;
    kept = ranges[last];
    ranges[last] = (kept & 0xFFFFu) | (uint32_t)STP_RANGE_INFINITE << 16; // a base splat at the end
    CHECK(!stp_progressive_is_valid(ranges, count, order));
    ranges[last] = kept;
    ranges[order[0]] = kept; // one parent fewer
    stp_progressive_order(ranges, count, order, f.scratch);
    CHECK(!stp_progressive_is_whole(ranges, count, order));
    tear_down(&f);
    CHECK(set_up(&f, 3));
    f.set.ranges[0] = 0xFF00FF83u; // an invalid lowest level
    stp_progressive_order(f.set.ranges, count, order, f.scratch);
    CHECK(!stp_progressive_is_valid(f.set.ranges, count, order));
    tear_down(&f);
    CHECK(set_up(&f, 3));
    f.set.ranges[last] = 0xFEFFFEFFu; // a child above its parent
    stp_progressive_order(f.set.ranges, count, order, f.scratch);
    CHECK(!stp_progressive_is_valid(f.set.ranges, count, order));
    tear_down(&f);
}

// The rule by codes and the two levels, as the range test of the rasterisers applies it.
void test_progressive_cuts_have_any_count(test_state* test)
{
    for (size_t n = 0; n < SAMPLES; ++n) {
        fixture f;
        CHECK(set_up(&f, n));
        uint32_t maximum = f.counts.base + f.counts.splits;
        for (uint32_t wanted = 0; wanted <= maximum + 2; ++wanted) {
            bool alive[MOST];
            uint32_t drawn = 0;
            uint32_t expected = progressive_sample_mark(f.counts, f.order, wanted, alive);
            stp_progressive_cut cut = stp_progressive_find_cut(f.set.ranges, f.set.count, wanted);
            CHECK_EQUAL(expected, cut.splats);
            CHECK_EQUAL(f.counts.base + 2 * (expected - f.counts.base), cut.end);
            for (uint32_t i = 0; i < cut.end; ++i) {
                uint32_t range = f.set.ranges[i], low = range & 0xFFFFu;
                uint32_t bits = stp_bits_of_float(i < cut.divide ? cut.below : cut.level);
                bool rule = low < cut.code || (low == cut.code && i >= cut.divide);
                bool shown = bits >= low << 15 && bits <= range >> 16 << 15;
                CHECK(rule == alive[i] && shown == rule);
                drawn += shown ? 1 : 0;
            }
            CHECK_EQUAL(expected, drawn);
        }
        tear_down(&f);
    }
}
