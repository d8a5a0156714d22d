// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/io/spill.h"
#include "scene/partition_steps.h"

#include <string.h>
#include <unistd.h>

enum { LONG = 4500000, SHORT = 5000, PIECES = 6 }; // LONG: more than one thread divides alone

static stp_context* context;
static stp_place* in_heap;
static uint32_t ends[PIECES];

static bool comes_before(const stp_place* a, const stp_place* b, int axis)
{
    return a->at[axis] < b->at[axis] || (a->at[axis] == b->at[axis] && a->index < b->index);
}

// Few values, so that many places coincide along an axis. Axis 0 is the longest.
static void make_places(stp_place* places, uint32_t count)
{
    uint32_t random = 1;
    for (uint32_t i = 0; i < count; ++i) {
        for (int k = 0; k < 3; ++k) {
            random = random * 1664525u + 1013904223u;
            places[i].at[k] = (float)(random >> 20) / (float)(1 << 4 * k);
        }
        places[i].index = i;
    }
}

// Whether all places are there, in runs of the right lengths with ascending indices, and the first
// half of the pieces is the lower one along the longest axis.
static bool is_split(const stp_place* places, uint32_t count)
{
    unsigned char* seen = calloc(count, 1);
    bool good = seen != NULL && ends[PIECES - 1] == count;
    uint32_t piece = 0, middle = ends[PIECES / 2 - 1];
    for (uint32_t i = 0; i < count && good; ++i) {
        bool begins = i == 0 || i == ends[piece];
        piece += i > 0 && begins;
        good = places[i].index < count && seen[places[i].index]++ == 0 &&
               (begins || places[i].index > places[i - 1].index) &&
               ends[piece] - (piece > 0 ? ends[piece - 1] : 0) <= (count + PIECES - 1) / PIECES;
    }
    free(seen);
    stp_place last = places[0];
    for (uint32_t i = 1; i < middle; ++i) {
        last = comes_before(&last, &places[i], 0) ? places[i] : last;
    }
    for (uint32_t i = middle; i < count && good; ++i) {
        good = comes_before(&last, &places[i], 0);
    }
    return good && middle == count / 2;
}

static uint64_t resident_bytes(void)
{
    unsigned long all = 0, resident = 0;
    FILE* file = fopen("/proc/self/statm", "r");
    int got = file != NULL ? fscanf(file, "%lu %lu", &all, &resident) : 0;
    if (file != NULL) {
        fclose(file);
    }
    return got == 2 ? (uint64_t)resident * (uint64_t)sysconf(_SC_PAGESIZE) : 0;
}

void test_split_ranges_divide_by_planes(test_state* test)
{
    static const uint32_t counts[] = {SHORT, LONG};
    in_heap = malloc(sizeof(stp_place) * LONG);
    CHECK(in_heap != NULL);
    for (size_t i = 0; i < 2; ++i) {
        context = test_context(NULL, 2, NULL);
        make_places(in_heap, counts[i]);
        CHECK_EQUAL(STP_OK,
                    stp_split_ranges(context, in_heap, counts[i], counts[i], PIECES, false, ends));
        CHECK(is_split(in_heap, counts[i]));
        stp_context_destroy(context);
    }
    free(in_heap);
}

// Of places in a spill, little stays resident, and they are split in the same way.
void test_split_ranges_leave_pages_of_a_spill(test_state* test)
{
    stp_spill* spill = NULL;
    const size_t size = sizeof(stp_place) * LONG;
    context = test_context(NULL, 1, NULL);
    in_heap = malloc(size);
    CHECK(in_heap != NULL && stp_spill_create(context, "/tmp", &spill) == STP_OK);
    stp_place* in_spill = stp_spill_alloc(spill, size);
    CHECK(in_spill != NULL);
    make_places(in_spill, LONG);
    make_places(in_heap, LONG);
    CHECK_EQUAL(STP_OK, stp_split_ranges(context, in_heap, LONG, LONG, PIECES, false, ends));
    CHECK_EQUAL(STP_OK, stp_split_ranges(context, in_spill, LONG, LONG, PIECES, true, ends));
    uint64_t without = resident_bytes();
    CHECK(memcmp(in_heap, in_spill, size) == 0); // reads all of it
    uint64_t with = resident_bytes();
    CHECK(without == 0 || with > without + size / 10 * 9);
    stp_spill_destroy(spill);
    free(in_heap);
    stp_context_destroy(context);
}
