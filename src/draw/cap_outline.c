// SPDX-License-Identifier: MIT
#include "draw/caps_internal.h"

#include <assert.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
    SEGMENTS_MAX = 1 << 22,
    REACH = 512 ///< begin points compared with an end point, on either side along an axis
};

stp_result stp_cap_outline_add(stp_context* context, stp_cap_outline* o, const float from[3],
                               const float to[3])
{
    if (o->count >= SEGMENTS_MAX) {
        return STP_OK;
    }
    if (!STP_MAKE_ROOM(context, o->segments, o->capacity, o->count + 1)) {
        return stp_fail_memory(context);
    }
    assert(o->count < o->capacity);
    memcpy(o->segments[o->count].from, from, sizeof(o->segments->from));
    memcpy(o->segments[o->count].to, to, sizeof(o->segments->to));
    o->count += 1;
    return STP_OK;
}

// An end of a segment.
typedef struct place {
    float at[3];
    int32_t begins; ///< 1: a segment begins here; -1: one ends
    bool taken;
} place;

static int compare_floats(float a, float b)
{
    return (a > b) - (a < b);
}

static int compare_places(const void* a, const void* b)
{
    const place *x = a, *y = b;
    for (int k = 0; k < 3; ++k) {
        if (x->at[k] != y->at[k]) {
            return compare_floats(x->at[k], y->at[k]);
        }
    }
    return x->begins - y->begins;
}

// Keeps only unmatched begin and end points, still sorted. @return their count
static size_t find_loose(place* places, size_t count)
{
    size_t left = 0;
    for (size_t i = 0, end; i < count; i = end) {
        int64_t net = 0;
        for (end = i; end < count && memcmp(places[end].at, places[i].at, sizeof(places->at)) == 0;
             ++end) {
            net += places[end].begins;
        }
        assert(left <= i && "the list only shrinks");
        place one = places[i];
        one.begins = net > 0 ? 1 : -1;
        for (int64_t k = net < 0 ? -net : net; k > 0; --k) {
            places[left++] = one;
        }
    }
    return left;
}

static double distance_squared(const place* a, const place* b)
{
    double sum = 0.0;
    for (int k = 0; k < 3; ++k) {
        double d = (double)a->at[k] - (double)b->at[k];
        sum += d * d;
    }
    return sum;
}

#ifndef NDEBUG
// Whether as many segments begin as end.
static bool are_balanced(const place* places, size_t count)
{
    int64_t net = 0;
    for (size_t i = 0; i < count; ++i) {
        net += places[i].begins;
    }
    return net == 0;
}
#endif

// The nearest free begin point, or `count`. Searches a window of the sorted points; cracks are
// narrow.
static size_t find_beginning(const place* places, size_t count, size_t end)
{
    size_t best = count, seen = 0;
    assert(end < count && places[end].begins < 0 && "only ends look for a beginning");
    double minimum = HUGE_VAL;
    for (size_t step = 1; step < count && (seen < REACH || best == count); ++step) {
        const size_t both[2] = {end + step, end - step};
        for (int k = 0; k < 2; ++k) {
            bool there = k == 0 ? end + step < count : step <= end;
            if (there && places[both[k]].begins > 0 && !places[both[k]].taken) {
                double d = distance_squared(&places[end], &places[both[k]]);
                best = d < minimum ? both[k] : best;
                minimum = d < minimum ? d : minimum;
                seen += 1;
            }
        }
    }
    return best;
}

stp_result stp_cap_outline_close(stp_context* context, stp_cap_outline* o)
{
    size_t count = 2 * o->count;
    place* places = STP_NEW_ARRAY(context, place, count + 1);
    if (places == NULL) {
        return stp_fail_memory(context);
    }
    for (size_t i = 0; i < o->count; ++i) {
        for (int k = 0; k < 2; ++k) {
            const float* from = k == 0 ? o->segments[i].from : o->segments[i].to;
            place* to = &places[2 * i + (size_t)k];
            *to = (place){.begins = k == 0 ? 1 : -1};
            for (int axis = 0; axis < 3; ++axis) {
                to->at[axis] = from[axis] + 0.0f; // -0 is 0
            }
        }
    }
    qsort(places, count, sizeof(place), compare_places);
    count = find_loose(places, count);
    assert(are_balanced(places, count) && "each segment has two ends");
    stp_result result = STP_OK;
    for (size_t i = 0; i < count && result == STP_OK; ++i) {
        size_t found = places[i].begins < 0 ? find_beginning(places, count, i) : count;
        if (found < count) {
            places[found].taken = true;
            result = stp_cap_outline_add(context, o, places[i].at, places[found].at);
        }
    }
    stp_free(context, places);
    return result;
}
