// SPDX-License-Identifier: MIT
//
// A k-d tree: each run is divided across its longest axis, in proportion to the number of pieces it
// must give. Ties are broken by index, so coinciding places are divided as well. Long runs are
// divided level by level, short ones by one thread each down to the pieces. Of places that lie in a
// file, only a window of each pass and the short runs at work are resident.
#include "base/core/jobs.h"
#include "base/io/spill.h"
#include "scene/partition_steps.h"

#include <assert.h>
#include <string.h>

enum {
    DIGIT_BITS = 11,
    SAMPLE = 127,
    LARGE_RANGE = 1 << 16,
    SHORT_RUN = 1 << 22, // places
    WINDOW = 1 << 20,    // places that a pass over a long run leaves behind at once
    DEPTH = 33           // runs that wait while one is divided: halves of at most 2^32 pieces
};

typedef struct run {
    uint32_t first, count, first_piece, pieces;
} run;

typedef struct splitting {
    stp_place* places;
    bool in_spill;      ///< the places lie in a spill
    run *from, *to;     ///< runs of this level and the next; at most two for each run of this one
    stp_place* scratch; ///< room for the longest piece, for each thread
    uint32_t maximum;   ///< maximum places of a piece
    uint32_t* ends;     ///< end of each piece
    unsigned index_bits;
} splitting;

// Leaves places behind that a pass is done with.
static inline void leave(const stp_place* places, uint32_t count, bool in_spill)
{
    if (in_spill) {
        stp_spill_forget(places, count * sizeof(*places));
    }
}

static bool comes_before(const stp_place* a, const stp_place* b, int axis)
{
    return a->at[axis] < b->at[axis] || (a->at[axis] == b->at[axis] && a->index < b->index);
}

static int longest_axis(const stp_place* places, uint32_t count, bool in_spill)
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
        if (i % WINDOW == 0) {
            leave(places + i - WINDOW, WINDOW, in_spill);
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

// Chooses a pivot in [low, high] whose rank is expected to be close to `rank`: a quantile of a few
// random samples. It usually discards most of a large range immediately.
static stp_place choose_pivot(const stp_place* places, uint32_t low, uint32_t high, uint32_t rank,
                              int axis, uint64_t* random)
{
    stp_place sample[SAMPLE];
    uint32_t size = high - low + 1, count = size > LARGE_RANGE ? SAMPLE : 1;
    for (uint32_t i = 0; i < count; ++i) {
        *random = *random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        stp_place place = places[low + (uint32_t)((*random >> 33) % size)];
        uint32_t at = i;
        for (; at > 0 && comes_before(&place, &sample[at - 1], axis); --at) {
            sample[at] = sample[at - 1];
        }
        sample[at] = place;
    }
    return sample[(uint32_t)((uint64_t)(rank - low) * count / size)];
}

// Hoare's selection: moves the `rank` smallest along the axis to the front.
static void select_first(stp_place* places, uint32_t count, uint32_t rank, int axis, bool in_spill)
{
    assert(rank > 0 && rank <= count);
    uint32_t low = 0, high = count - 1; // the last of the first `rank` is at rank - 1
    uint64_t random = count;
    while (low < high) {
        stp_place pivot = choose_pivot(places, low, high, rank - 1, axis, &random);
        uint32_t i = low, j = high;
        for (;;) {
            while (comes_before(&places[i], &pivot, axis)) {
                i += 1;
                if (i % WINDOW == 0) {
                    leave(places + i - WINDOW, WINDOW, in_spill);
                }
            }
            while (comes_before(&pivot, &places[j], axis)) {
                if (j % WINDOW == 0) {
                    leave(places + j, count - j < WINDOW ? count - j : WINDOW, in_spill);
                }
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
        assert(i == j && i >= low && i <= high);
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

// Divides a run of several pieces in two.
static void divide(const splitting* c, run r, bool in_spill, run halves[2])
{
    assert(r.pieces > 1);
    stp_place* places = c->places + r.first;
    uint32_t left_pieces = r.pieces / 2;
    uint32_t left = (uint32_t)((uint64_t)r.count * left_pieces / r.pieces);
    if (left > 0) {
        int axis = longest_axis(places, r.count, in_spill);
        select_first(places, r.count, left, axis, in_spill);
    }
    halves[0] = (run){r.first, left, r.first_piece, left_pieces};
    halves[1] =
        (run){r.first + left, r.count - left, r.first_piece + left_pieces, r.pieces - left_pieces};
}

static bool is_long(run r)
{
    return r.count > SHORT_RUN && r.pieces > 1;
}

static void divide_runs(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const splitting* c = user;
    for (size_t i = begin; i < end; ++i) {
        run r = c->from[i];
        c->to[2 * i] = r;
        c->to[2 * i + 1] = (run){0};
        if (is_long(r)) {
            divide(c, r, c->in_spill, &c->to[2 * i]);
            leave(c->places + r.first, r.count, c->in_spill);
        }
    }
}

// Radix sort by the lower `bits` of indices, between `places` and `scratch`. @return the array with
// the result
static stp_place* sort_by_index(stp_place* places, stp_place* scratch, uint32_t count,
                                unsigned bits)
{
    for (unsigned shift = 0; shift < bits; shift += DIGIT_BITS) {
        uint32_t starts[1 << DIGIT_BITS] = {0}, sum = 0, mask = (1u << DIGIT_BITS) - 1;
        for (uint32_t i = 0; i < count; ++i) {
            starts[places[i].index >> shift & mask] += 1;
        }
        for (uint32_t digit = 0; digit <= mask; ++digit) {
            uint32_t size = starts[digit];
            starts[digit] = sum;
            sum += size;
        }
        for (uint32_t i = 0; i < count; ++i) {
            scratch[starts[places[i].index >> shift & mask]++] = places[i];
        }
        stp_place* swap = places;
        places = scratch;
        scratch = swap;
    }
    return places;
}

static void finish_piece(splitting* c, run r, stp_place* scratch)
{
    assert(r.count <= c->maximum && "no longer than the scratch");
    stp_place* places = c->places + r.first;
    if (sort_by_index(places, scratch, r.count, c->index_bits) != places) {
        memcpy(places, scratch, r.count * sizeof(*places));
    }
    c->ends[r.first_piece] = r.first + r.count;
}

// Divides short runs down to their pieces.
static void finish_runs(size_t begin, size_t end, uint32_t worker, void* user)
{
    splitting* c = user;
    stp_place* scratch = c->scratch + (size_t)worker * c->maximum;
    for (size_t i = begin; i < end; ++i) {
        run stack[DEPTH];
        uint32_t waiting = 1;
        stack[0] = c->from[i];
        while (waiting > 0) {
            run r = stack[--waiting];
            if (r.pieces == 1) {
                finish_piece(c, r, scratch);
                continue;
            }
            run halves[2];
            assert(waiting + 2 <= DEPTH);
            divide(c, r, false, halves);
            stack[waiting++] = halves[1];
            stack[waiting++] = halves[0];
        }
        leave(c->places + c->from[i].first, c->from[i].count, c->in_spill);
    }
}

// Removes the empty places behind runs that were not divided. @return how many are left
static uint32_t keep_runs(run* runs, uint32_t count, bool* any_long)
{
    uint32_t kept = 0;
    *any_long = false;
    for (uint32_t i = 0; i < count; ++i) {
        if (runs[i].pieces > 0) {
            *any_long = *any_long || is_long(runs[i]);
            runs[kept++] = runs[i];
        }
    }
    return kept;
}

static stp_result split_all(stp_context* context, splitting* c, uint32_t count, uint32_t index_end,
                            uint32_t pieces)
{
    bool any_long;
    c->from[0] = (run){0, count, 0, pieces};
    uint32_t run_count = keep_runs(c->from, 1, &any_long);
    while (any_long) {
        stp_parallel_for(context, run_count, 1, divide_runs, c);
        run* swap = c->from;
        c->from = c->to;
        c->to = swap;
        run_count = keep_runs(c->from, 2 * run_count, &any_long);
    }
    while (c->index_bits < 32 && index_end >> c->index_bits != 0) {
        c->index_bits += 1;
    }
    uint32_t threads = stp_context_thread_count(context);
    threads = threads < run_count ? threads : run_count;
    c->maximum = count / pieces + (count % pieces != 0);
    c->scratch = STP_NEW_ARRAY(context, stp_place, (size_t)c->maximum * threads);
    if (c->scratch == NULL) {
        return stp_fail_memory(context);
    }
    stp_team team = stp_team_create(context, threads);
    stp_team_run(&team, run_count, 1, finish_runs, c);
    stp_free(context, c->scratch);
    return STP_OK;
}

stp_result stp_split_ranges(stp_context* context, stp_place* places, uint32_t count,
                            uint32_t index_end, uint32_t pieces, bool in_spill, uint32_t* ends)
{
    assert(pieces > 0 && count <= index_end);
    splitting c = {.places = places, .in_spill = in_spill, .ends = ends};
    run* runs = STP_NEW_ARRAY(context, run, 4 * (size_t)pieces);
    if (runs == NULL) {
        return stp_fail_memory(context);
    }
    c.from = runs;
    c.to = runs + 2 * (size_t)pieces;
    stp_result result = split_all(context, &c, count, index_end, pieces);
    assert(result != STP_OK || ends[pieces - 1] == count);
    stp_free(context, runs);
    return result;
}
