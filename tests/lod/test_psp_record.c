// SPDX-License-Identifier: MIT
// The record of merges (src/lod/psp/rank_merges.c): its splits undo the merges in reverse order.
#include "tests.h"

#include "base/math/rng.h"
#include "base/splats/progressive.h"
#include "base/splats/splat_codes.h"
#include "lod/psp/forest.h"

#include <string.h>

enum { FEW = 3000, MANY = 60000 };

static stp_psp_merge merges[MANY];
static uint32_t parents[2 * MANY], alive[MANY], order[2 * MANY], scratch[2 * MANY];

/// A forest of random merges without geometry; `left` splats remain.
static stp_psp_forest make_forest(uint32_t points, uint32_t left)
{
    stp_psp_forest f = {
        .point_count = points, .merge_count = points - left, .merges = merges, .parents = parents};
    memset(parents, 0xff, sizeof(parents));
    for (uint32_t i = 0; i < points; ++i) {
        alive[i] = i;
    }
    for (uint32_t i = 0; i < f.merge_count; ++i) {
        uint32_t live = points - i, parts[2];
        for (uint32_t k = 0; k < 2; ++k) { // takes one out, the last one moves to its place
            uint32_t at = (uint32_t)stp_rng_below(7, 2 * i + k, live - k);
            parts[k] = alive[at];
            alive[at] = alive[live - 1 - k];
        }
        alive[live - 2] = points + i;
        parents[parts[0]] = parents[parts[1]] = i;
        bool swapped = parts[0] > parts[1];
        merges[i] =
            (stp_psp_merge){.left = parts[swapped ? 1 : 0], .right = parts[swapped ? 0 : 1]};
    }
    return f;
}

/// Checks the sequence of a ranked forest.
/// @param away how far from its place in the reverse order a merge may be undone
static void check_record(test_state* test, uint32_t points, uint32_t left, uint32_t away)
{
    stp_context* context = test_context(NULL, 1, NULL);
    stp_psp_forest f = make_forest(points, left);
    stp_psp_sequence s;
    CHECK_EQUAL(STP_OK, stp_psp_rank_merges(context, &f));
    CHECK_EQUAL(STP_OK, stp_psp_sequence_make(context, &f, &s));
    CHECK_EQUAL(points + f.merge_count, s.count);
    uint32_t splits = stp_progressive_order(s.ranges, s.count, order, scratch);
    CHECK_EQUAL(f.merge_count, splits);
    CHECK(stp_progressive_is_whole(s.ranges, s.count, order));
    stp_progressive_counts counts = stp_progressive_count(s.ranges, s.count);
    CHECK_EQUAL(left, counts.base);
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < splits; ++i) {
        const stp_psp_merge* m = &merges[s.splats[order[i]] - points];
        uint32_t due = f.merge_count - 1 - i, at = (uint32_t)(m - merges);
        wrong += (at > due ? at - due : due - at) > away;
        const uint32_t* parts = s.splats + left + 2 * i; // they replace that merge
        wrong += parts[0] != m->left || parts[1] != m->right;
    }
    CHECK_EQUAL(0, wrong);
    for (uint32_t i = 0; i < s.count; ++i) { // any size of a view draws the base set alone
        bool drawn = STP_PSP_RANK_MAX <= stp_range_level(s.ranges[i] >> 16);
        wrong += drawn != (i < left);
    }
    CHECK_EQUAL(0, wrong);
    stp_psp_sequence_destroy(context, &s);
    stp_context_destroy(context);
}

void test_psp_records_undo_merges_in_reverse(test_state* test)
{
    check_record(test, FEW, 1, 0);
    check_record(test, FEW, 900, 0); // splats that are left are split in order, too
    check_record(test, 2, 1, 0);
    check_record(test, 5, 5, 0);
    check_record(test, MANY, 10, 8); // more runs of merges than ranks
}

void test_psp_records_survive_failing_allocator(test_state* test)
{
    bool made = false;
    for (int n = 1; !made && n < 10; ++n) {
        test_heap heap = TEST_HEAP(n);
        stp_context* context = test_context(&heap, 1, NULL);
        stp_psp_forest f = make_forest(20, 3);
        if (context != NULL) {
            made = stp_psp_rank_merges(context, &f) == STP_OK;
            CHECK(made == f.ranked);
        }
        stp_context_destroy(context);
        CHECK_EQUAL(0, heap.live_bytes);
    }
    CHECK(made);
}
