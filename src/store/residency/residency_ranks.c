// SPDX-License-Identifier: MIT
// Binary min-heaps of ranks.
#include "store/residency/residency_internal.h"

#include <assert.h>

static bool is_before(const stp_rank* a, const stp_rank* b)
{
    return a->order != b->order ? a->order < b->order : a->resource < b->resource;
}

void stp_ranks_sink(stp_rank* ranks, size_t count, size_t at)
{
    assert(at < count || count == 0);
    for (;;) {
        size_t minimum = at;
        for (size_t child = 2 * at + 1; child <= 2 * at + 2 && child < count; ++child) {
            minimum = is_before(&ranks[child], &ranks[minimum]) ? child : minimum;
        }
        if (minimum == at) {
            return;
        }
        stp_rank moved = ranks[at];
        ranks[at] = ranks[minimum];
        ranks[minimum] = moved;
        at = minimum;
    }
}

#ifndef NDEBUG
static bool is_heap(const stp_rank* ranks, size_t count)
{
    for (size_t i = 1; i < count; ++i) {
        if (is_before(&ranks[i], &ranks[(i - 1) / 2])) {
            return false;
        }
    }
    return true;
}
#endif

void stp_ranks_sort(stp_rank* ranks, size_t count)
{
    for (size_t at = count / 2; at-- > 0;) {
        stp_ranks_sink(ranks, count, at);
    }
    assert(is_heap(ranks, count));
}

size_t stp_ranks_pop(stp_rank* ranks, size_t count)
{
    assert(count > 0);
    ranks[0] = ranks[count - 1];
    stp_ranks_sink(ranks, count - 1, 0);
    return count - 1;
}
