// SPDX-License-Identifier: MIT
#include "lab/decimate/subsample_cover.h"

#include <assert.h>
#include <string.h>

stp_result stp_cover_problem_index(stp_context* context, stp_cover_problem* p)
{
    size_t total = p->starts[p->set_count];
    p->set_starts = STP_NEW_ZEROED(context, size_t, (size_t)p->point_count + 2);
    p->sets = STP_NEW_ARRAY(context, uint32_t, total + 1);
    if (p->set_starts == NULL || p->sets == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < total; ++i) {
        assert(p->members[i] < p->point_count);
        p->set_starts[(size_t)p->members[i] + 2]++;
    }
    for (size_t i = 2; i < (size_t)p->point_count + 2; ++i) {
        p->set_starts[i] += p->set_starts[i - 1];
    }
    for (uint32_t s = 0; s < p->set_count; ++s) { // starts of points become their ends
        for (size_t i = p->starts[s]; i < p->starts[s + 1]; ++i) {
            p->sets[p->set_starts[(size_t)p->members[i] + 1]++] = s;
        }
    }
    assert(p->set_starts[0] == 0 && p->set_starts[p->point_count] == total);
    return STP_OK;
}

void stp_cover_problem_destroy(stp_context* context, stp_cover_problem* problem)
{
    stp_free(context, problem->set_starts);
    stp_free(context, problem->sets);
    problem->set_starts = NULL;
    problem->sets = NULL;
}

void stp_cover_add(const stp_cover_problem* p, stp_cover* cover, uint32_t set)
{
    assert(cover->places[set] == UINT32_MAX && "chosen once");
    cover->places[set] = cover->count;
    cover->chosen[cover->count++] = set;
    for (size_t i = p->starts[set]; i < p->starts[set + 1]; ++i) {
        cover->depths[p->members[i]]++;
    }
}

void stp_cover_remove(const stp_cover_problem* p, stp_cover* cover, uint32_t set)
{
    assert(cover->places[set] < cover->count && cover->chosen[cover->places[set]] == set);
    uint32_t place = cover->places[set], last = cover->chosen[--cover->count];
    cover->chosen[place] = last;
    cover->places[last] = place;
    cover->places[set] = UINT32_MAX;
    for (size_t i = p->starts[set]; i < p->starts[set + 1]; ++i) {
        assert(cover->depths[p->members[i]] > 0);
        cover->depths[p->members[i]]--;
    }
}

bool stp_cover_is_redundant(const stp_cover_problem* p, const stp_cover* cover, uint32_t set)
{
    for (size_t i = p->starts[set]; i < p->starts[set + 1]; ++i) {
        if (cover->depths[p->members[i]] < 2) {
            return false;
        }
    }
    return true;
}

/// A set and its weight when it was pushed on the heap. Weights only fall, so the first entry with
/// a current weight is the maximum.
typedef struct entry {
    uint64_t gain;
    uint32_t set;
} entry;

static bool before(entry a, entry b)
{
    return a.gain > b.gain || (a.gain == b.gain && a.set < b.set);
}

static void sift(entry* heap, uint32_t count, uint32_t at)
{
    entry item = heap[at];
    for (size_t child = 2 * (size_t)at + 1; child < count; child = 2 * (size_t)at + 1) {
        child += child + 1 < count && before(heap[child + 1], heap[child]) ? 1 : 0;
        if (!before(heap[child], item)) {
            break;
        }
        heap[at] = heap[child];
        at = (uint32_t)child;
    }
    heap[at] = item;
}

/// Subtracts the weights of a set's uncovered points from the gains of all sets that contain them.
static void take_points(const stp_cover_problem* p, const stp_cover* cover, uint32_t set,
                        uint64_t* gains)
{
    for (size_t i = p->starts[set]; i < p->starts[set + 1]; ++i) {
        uint32_t point = p->members[i];
        for (size_t s = p->set_starts[point];
             cover->depths[point] == 0 && s < p->set_starts[point + 1]; ++s) {
            assert(gains[p->sets[s]] >= p->weights[point]);
            gains[p->sets[s]] -= p->weights[point];
        }
    }
}

#ifndef NDEBUG
static bool covers_all(const stp_cover_problem* p, const stp_cover* cover)
{
    for (uint32_t i = 0; i < p->point_count; ++i) {
        if (cover->depths[i] == 0) {
            return false;
        }
    }
    return true;
}
#endif

stp_result stp_cover_greedily(stp_context* context, const stp_cover_problem* p, stp_cover* cover)
{
    uint32_t count = p->set_count;
    uint64_t* gains = STP_NEW_ZEROED(context, uint64_t, (size_t)count + 1);
    entry* heap = STP_NEW_ARRAY(context, entry, (size_t)count + 1);
    *cover = (stp_cover){.chosen = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1),
                         .places = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1),
                         .depths = STP_NEW_ZEROED(context, uint32_t, (size_t)p->point_count + 1)};
    if (gains == NULL || heap == NULL || cover->chosen == NULL || cover->places == NULL ||
        cover->depths == NULL) {
        stp_free(context, gains);
        stp_free(context, heap);
        return stp_fail_memory(context);
    }
    memset(cover->places, 0xff, ((size_t)count + 1) * sizeof(*cover->places));
    for (uint32_t s = 0; s < count; ++s) {
        for (size_t i = p->starts[s]; i < p->starts[s + 1]; ++i) {
            gains[s] += p->weights[p->members[i]];
        }
        heap[s] = (entry){gains[s], s};
    }
    for (uint32_t s = count / 2; s-- > 0;) {
        sift(heap, count, s);
    }
    while (count > 0) {
        entry first = heap[0];
        assert(first.gain >= gains[first.set] && "gains only fall");
        if (first.gain == gains[first.set] && first.gain > 0) {
            take_points(p, cover, first.set, gains);
            stp_cover_add(p, cover, first.set);
        }
        if (gains[first.set] == 0) {
            heap[0] = heap[--count];
        } else {
            heap[0].gain = gains[first.set];
        }
        if (count > 0) {
            sift(heap, count, 0);
        }
    }
    assert(covers_all(p, cover));
    stp_free(context, gains);
    stp_free(context, heap);
    return STP_OK;
}

void stp_cover_destroy(stp_context* context, stp_cover* cover)
{
    stp_free(context, cover->chosen);
    stp_free(context, cover->places);
    stp_free(context, cover->depths);
    *cover = (stp_cover){0};
}
