// SPDX-License-Identifier: MIT
#include "base/math/rng.h"
#include "lod/psp/kd_tree.h"

#include <assert.h>
#include <string.h>

enum {
    SAMPLES_MAX = 31, ///< maximum number of sampled pivot candidates
    SAMPLED_MIN = 64,
    SPREAD_SAMPLES = 64,
    SMALL = 12,       ///< ranges up to this size are sorted by insertion
    STRIPE = 1 << 20, ///< pages are released after this many points
};

int stp_kd_widest(const stp_kd_point* points, size_t count)
{
    assert(count > 0);
    // estimated from a sample if there are many points
    size_t step = count > SPREAD_SAMPLES ? count / SPREAD_SAMPLES : 1;
    float low[3], high[3];
    memcpy(low, points[0].at, sizeof(low));
    memcpy(high, points[0].at, sizeof(high));
    for (size_t i = step; i < count; i += step) {
        for (int axis = 0; axis < 3; ++axis) {
            float x = points[i].at[axis];
            low[axis] = x < low[axis] ? x : low[axis];
            high[axis] = x > high[axis] ? x : high[axis];
        }
    }
    int widest = high[1] - low[1] > high[0] - low[0] ? 1 : 0;
    return high[2] - low[2] > high[widest] - low[widest] ? 2 : widest;
}

/// Sort key: by coordinate, then by index.
static inline uint64_t key_of(const stp_kd_point* p, int axis)
{
    uint32_t bits;
    float x = p->at[axis] + 0.0f; // -0 becomes 0
    memcpy(&bits, &x, sizeof(bits));
    bits ^= (uint32_t)((int32_t)bits >> 31) | 0x80000000u;
    return (uint64_t)bits << 32 | p->index;
}

static void sort_small(stp_kd_point* points, size_t count, int axis)
{
    for (size_t i = 1; i < count; ++i) {
        stp_kd_point p = points[i];
        uint64_t key = key_of(&p, axis);
        size_t at = i;
        for (; at > 0 && key_of(&points[at - 1], axis) > key; --at) {
            points[at] = points[at - 1];
        }
        points[at] = p;
    }
}

/// Position of a pivot: the sampled point whose rank is expected to be close to `place`.
static size_t choose_pivot(const stp_kd_point* points, size_t count, size_t place, int axis)
{
    size_t samples = count < SAMPLED_MIN ? 3 : count < 1024 ? 9 : SAMPLES_MAX;
    uint64_t keys[SAMPLES_MAX];
    size_t places[SAMPLES_MAX];
    for (size_t s = 0; s < samples; ++s) {
        size_t from = (size_t)(stp_rng_hash(count, s) % count);
        uint64_t key = key_of(&points[from], axis);
        size_t at = s;
        for (; at > 0 && keys[at - 1] > key; --at) {
            keys[at] = keys[at - 1];
            places[at] = places[at - 1];
        }
        keys[at] = key;
        places[at] = from;
    }
    return places[place * samples / count];
}

/// Moves points before the pivot to the front. Branch-free: comparisons cannot be predicted here.
/// @return final position of the pivot
static size_t partition(stp_kd_point* points, size_t count, size_t pivot, int axis,
                        const stp_psp_room* room)
{
    assert(pivot < count);
    stp_kd_point middle = points[pivot];
    points[pivot] = points[count - 1];
    points[count - 1] = middle;
    uint64_t limit = key_of(&middle, axis);
    size_t store = 0;
    for (size_t begin = 0, end; begin + 1 < count; begin = end) {
        end = count - 1 - begin < STRIPE ? count - 1 : begin + STRIPE;
        for (size_t i = begin; i < end; ++i) {
            stp_kd_point p = points[i];
            points[i] = points[store];
            points[store] = p;
            store += key_of(&p, axis) < limit ? 1 : 0;
        }
        if (room != NULL && end - begin == STRIPE) {
            stp_psp_room_release(room);
        }
    }
    assert(store < count && "at least the pivot is not before the pivot");
    points[count - 1] = points[store];
    points[store] = middle;
    return store;
}

void stp_kd_select(stp_kd_point* points, size_t count, size_t place, int axis,
                   const stp_psp_room* room)
{
    assert(place < count && axis >= 0 && axis < 3);
    while (count > SMALL) {
        size_t pivot = choose_pivot(points, count, place, axis);
        size_t found = partition(points, count, pivot, axis, room);
        if (found == place) {
            return;
        }
        if (place < found) {
            count = found;
        } else {
            points += found + 1;
            count -= found + 1;
            place -= found + 1;
        }
        assert(place < count && "the wanted place stays in the range");
    }
    sort_small(points, count, axis);
}
