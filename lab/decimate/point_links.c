// SPDX-License-Identifier: MIT
#include "lab/decimate/contraction.h"

#include <assert.h>
#include <string.h>

/// Whether `to` is among the neighbours of `from`.
static bool is_near(const uint32_t* neighbours, uint32_t k, uint32_t from, uint32_t to)
{
    const uint32_t* near = neighbours + (size_t)k * from;
    for (uint32_t n = 0; n < k && near[n] != UINT32_MAX; ++n) {
        if (near[n] == to) {
            return true;
        }
    }
    return false;
}

/// Whether a pair is counted at `from`: mutual neighbours count at the lower one.
static bool is_own(const uint32_t* neighbours, uint32_t k, uint32_t from, uint32_t to)
{
    return from < to || !is_near(neighbours, k, to, from);
}

static void append(stp_point_links* l, uint32_t from, uint32_t to)
{
    uint32_t entry = l->last[from]++;
    l->targets[entry] = to;
}

/// Sets the start of each point's list. @return number of entries
static uint64_t place_lists(stp_point_links* l, const uint32_t* neighbours, uint32_t k)
{
    uint64_t entries = 0;
    for (uint32_t i = 0; i < l->count; ++i) {
        for (uint32_t n = 0; n < k && neighbours[(size_t)k * i + n] != UINT32_MAX; ++n) {
            uint32_t other = neighbours[(size_t)k * i + n];
            assert(other < l->count && other != i);
            if (is_own(neighbours, k, i, other)) {
                l->last[i] += 1;
                l->last[other] += 1;
            }
        }
    }
    for (uint32_t i = 0; i < l->count; ++i) {
        l->first[i] = (uint32_t)entries;
        entries += l->last[i];
        l->last[i] = l->first[i];
    }
    return entries;
}

static void fill_lists(stp_point_links* l, const uint32_t* neighbours, uint32_t k)
{
    for (uint32_t i = 0; i < l->count; ++i) {
        for (uint32_t n = 0; n < k && neighbours[(size_t)k * i + n] != UINT32_MAX; ++n) {
            uint32_t other = neighbours[(size_t)k * i + n];
            if (is_own(neighbours, k, i, other)) {
                append(l, i, other);
                append(l, other, i);
            }
        }
    }
    for (uint32_t i = 0; i < l->count; ++i) {
        bool empty = l->first[i] == l->last[i];
        assert((i + 1 == l->count || l->last[i] == l->first[i + 1]) && "lists have no gaps");
        for (uint32_t e = l->first[i]; e < l->last[i]; ++e) {
            l->next[e] = e + 1 < l->last[i] ? e + 1 : UINT32_MAX;
        }
        l->last[i] = empty ? UINT32_MAX : l->last[i] - 1;
        l->first[i] = empty ? UINT32_MAX : l->first[i];
    }
}

stp_result stp_point_links_make(stp_context* context, const uint32_t* neighbours, uint32_t count,
                                uint32_t k, stp_point_links* l)
{
    size_t room = (size_t)count + 1;
    *l = (stp_point_links){.context = context,
                           .count = count,
                           .kept = STP_NEW_ARRAY(context, uint32_t, room),
                           .first = STP_NEW_ARRAY(context, uint32_t, room),
                           .last = STP_NEW_ZEROED(context, uint32_t, room),
                           .marks = STP_NEW_ZEROED(context, uint32_t, room)};
    if (l->kept == NULL || l->first == NULL || l->last == NULL || l->marks == NULL) {
        return stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count; ++i) {
        l->kept[i] = i;
    }
    uint64_t entries = place_lists(l, neighbours, k);
    if (entries >= UINT32_MAX) {
        return stp_fail(context, STP_ERROR_LIMIT,
                        "decimation: %llu links between points, at most 2^32 - 2",
                        (unsigned long long)entries);
    }
    l->targets = STP_NEW_ARRAY(context, uint32_t, entries + 1);
    l->next = STP_NEW_ARRAY(context, uint32_t, entries + 1);
    if (l->targets == NULL || l->next == NULL) {
        return stp_fail_memory(context);
    }
    fill_lists(l, neighbours, k);
    return STP_OK;
}

/// Finds the current point that a point has become.
static uint32_t find(stp_point_links* l, uint32_t point)
{
    while (l->kept[point] != point) {
        l->kept[point] = l->kept[l->kept[point]];
        point = l->kept[point];
    }
    return point;
}

void stp_point_links_unite(stp_point_links* l, uint32_t kept, uint32_t gone)
{
    assert(kept != gone && l->kept[kept] == kept && l->kept[gone] == gone);
    l->kept[gone] = kept;
    if (l->first[gone] == UINT32_MAX) {
        return;
    }
    if (l->first[kept] == UINT32_MAX) {
        l->first[kept] = l->first[gone];
    } else {
        l->next[l->last[kept]] = l->first[gone];
    }
    l->last[kept] = l->last[gone];
}

uint32_t stp_point_links_list(stp_point_links* l, uint32_t point, uint32_t* out)
{
    assert(point < l->count && l->kept[point] == point);
    if (++l->stamp == 0) {
        memset(l->marks, 0, l->count * sizeof(*l->marks));
        l->stamp = 1;
    }
    uint32_t count = 0, before = UINT32_MAX;
    l->marks[point] = l->stamp;
    for (uint32_t e = l->first[point]; e != UINT32_MAX; e = l->next[e]) {
        uint32_t target = find(l, l->targets[e]);
        l->targets[e] = target;
        if (l->marks[target] == l->stamp) {
            continue; // itself, or already listed: removes the entry
        }
        l->marks[target] = l->stamp;
        out[count++] = target;
        if (before == UINT32_MAX) {
            l->first[point] = e;
        } else {
            l->next[before] = e;
        }
        before = e;
    }
    l->last[point] = before;
    if (before == UINT32_MAX) {
        l->first[point] = UINT32_MAX;
    } else {
        l->next[before] = UINT32_MAX;
    }
    return count;
}

void stp_point_links_destroy(stp_point_links* l)
{
    stp_free(l->context, l->kept);
    stp_free(l->context, l->first);
    stp_free(l->context, l->last);
    stp_free(l->context, l->marks);
    stp_free(l->context, l->targets);
    stp_free(l->context, l->next);
    *l = (stp_point_links){.context = l->context};
}
