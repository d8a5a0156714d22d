// SPDX-License-Identifier: MIT
//
// A k-d tree, level by level: each run is divided across its longest axis, in proportion to the
// number of pieces it must give. Ties are broken by index, so coinciding places are divided as
// well.
#include "scene/cut_ranges.h"

#include <stdlib.h>

typedef struct run {
    uint32_t first, count, pieces;
} run;

typedef struct cutting {
    stp_place* places;
    run *from, *to; ///< of this level and the next; the next has two places per run
} cutting;

static bool comes_before(const stp_place* a, const stp_place* b, int axis)
{
    return a->at[axis] < b->at[axis] || (a->at[axis] == b->at[axis] && a->index < b->index);
}

static int longest_axis(const stp_place* places, uint32_t count)
{
    float low[3], high[3];
    for (int k = 0; k < 3; ++k) {
        low[k] = high[k] = places[0].at[k];
    }
    for (uint32_t i = 1; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            float x = places[i].at[k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    }
    int axis = 0;
    double longest = -1.0;
    for (int k = 0; k < 3; ++k) {
        double size = (double)high[k] - (double)low[k];
        axis = size > longest ? k : axis;
        longest = size > longest ? size : longest;
    }
    return axis;
}

// Hoare's selection: moves the `rank` smallest along the axis to the front.
static void select_first(stp_place* places, uint32_t count, uint32_t rank, int axis)
{
    uint32_t low = 0, high = count - 1; // the last of the first `rank` is at rank - 1
    uint64_t random = count;
    while (low < high) {
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        stp_place pivot = places[low + (uint32_t)((random >> 33) % (high - low + 1))];
        uint32_t i = low, j = high;
        for (;;) {
            while (comes_before(&places[i], &pivot, axis)) {
                i += 1;
            }
            while (comes_before(&pivot, &places[j], axis)) {
                j -= 1;
            }
            if (i >= j) {
                break;
            }
            stp_place swap = places[i];
            places[i] = places[j];
            places[j] = swap;
        }
        // the pivot is unique, at i == j
        if (rank - 1 == i) {
            return;
        }
        if (rank - 1 < i) {
            high = i - 1;
        } else {
            low = i + 1;
        }
    }
}

static int compare_indices(const void* a, const void* b)
{
    uint32_t x = ((const stp_place*)a)->index, y = ((const stp_place*)b)->index;
    return (x > y) - (x < y);
}

static void divide_runs(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const cutting* c = user;
    for (size_t i = begin; i < end; ++i) {
        run r = c->from[i];
        stp_place* places = c->places + r.first;
        uint32_t left_pieces = r.pieces / 2;
        uint32_t left = (uint32_t)((uint64_t)r.count * left_pieces / r.pieces);
        if (left > 0) {
            select_first(places, r.count, left, longest_axis(places, r.count));
        }
        c->to[2 * i] = (run){r.first, left, left_pieces};
        c->to[2 * i + 1] = (run){r.first + left, r.count - left, r.pieces - left_pieces};
    }
}

static void sort_runs(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const cutting* c = user;
    for (size_t i = begin; i < end; ++i) {
        qsort(c->places + c->from[i].first, c->from[i].count, sizeof(stp_place), compare_indices);
    }
}

// Removes the empty runs left by single pieces.
static uint32_t keep_runs(run* runs, uint32_t count)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < count; ++i) {
        if (runs[i].pieces > 0) {
            runs[kept++] = runs[i];
        }
    }
    return kept;
}

stp_result stp_cut_ranges(stp_context* context, stp_place* places, uint32_t count, uint32_t pieces,
                          uint32_t* ends)
{
    cutting c = {.places = places};
    run* runs = STP_NEW_ARRAY(context, run, 4 * (size_t)pieces);
    if (runs == NULL) {
        return stp_fail_memory(context);
    }
    c.from = runs;
    c.to = runs + 2 * (size_t)pieces;
    c.from[0] = (run){0, count, pieces};
    uint32_t run_count = 1;
    while (run_count < pieces) {
        stp_parallel_for(context, run_count, 1, divide_runs, &c);
        run* swap = c.from;
        c.from = c.to;
        c.to = swap;
        run_count = keep_runs(c.from, 2 * run_count);
    }
    stp_parallel_for(context, pieces, 1, sort_runs, &c);
    for (uint32_t i = 0; i < pieces; ++i) {
        ends[i] = c.from[i].first + c.from[i].count;
    }
    stp_free(context, runs);
    return STP_OK;
}
