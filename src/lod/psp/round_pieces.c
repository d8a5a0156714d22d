// SPDX-License-Identifier: MIT
#include "base/math/rng.h"
#include "lod/psp/rounds.h"

#include <assert.h>

typedef struct splitter {
    stp_psp_rounds* rounds;
    stp_psp_range *ranges, *next;
    uint32_t count, piece_size, depth;
} splitter;

static uint32_t split_of(const splitter* c, stp_psp_range of)
{
    uint32_t count = of.end - of.begin;
    if (c->rounds->round == 0) { // split positions in the tree
        uint32_t begin = of.begin / STP_KD_LEAF;
        uint32_t end = of.end / STP_KD_LEAF + (of.end % STP_KD_LEAF != 0 ? 1 : 0);
        return (begin + (end - begin) / 2) * STP_KD_LEAF;
    }
    // three to five eighths of the range, so that seams move from round to round
    uint64_t part = 384 + (stp_rng_hash(c->rounds->round, c->depth) & 255);
    return of.begin + (uint32_t)(count * part / 1024);
}

static bool is_small(const splitter* c, stp_psp_range of)
{
    uint32_t minimum = c->piece_size > STP_KD_LEAF ? c->piece_size : STP_KD_LEAF;
    return of.end - of.begin <= minimum;
}

static void split_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    const splitter* c = user;
    (void)worker;
    for (size_t i = begin; i < end; ++i) {
        stp_psp_range of = c->ranges[i];
        stp_psp_rounds_release(c->rounds, i);
        bool small = is_small(c, of);
        uint32_t middle = small ? of.end : split_of(c, of);
        assert(small || (of.begin < middle && middle < of.end));
        if (!small && c->rounds->order != NULL) {
            stp_kd_point* points = c->rounds->order + of.begin;
            size_t count = of.end - of.begin;
            stp_kd_select(points, count, middle - of.begin, stp_kd_widest(points, count),
                          &c->rounds->rooms[STP_PSP_ROOM_WORK]);
        }
        c->next[2 * i] = (stp_psp_range){of.begin, middle};
        c->next[2 * i + 1] = (stp_psp_range){middle, of.end};
    }
}

stp_result stp_psp_split_slots(stp_psp_rounds* r, uint32_t piece_size, stp_psp_range** ranges,
                               uint32_t* count)
{
    assert(piece_size > 0 && r->live > 0);
    // each piece holds more than a third of `piece_size`
    size_t maximum = 4 + 2 * (3 * (size_t)r->live / piece_size + 1);
    stp_context* context = r->shared.context;
    splitter c = {.rounds = r, .piece_size = piece_size, .count = 1};
    c.ranges = STP_NEW_ARRAY(context, stp_psp_range, maximum);
    c.next = STP_NEW_ARRAY(context, stp_psp_range, maximum);
    if (c.ranges == NULL || c.next == NULL) {
        stp_free(context, c.ranges);
        stp_free(context, c.next);
        return stp_fail_memory(context);
    }
    c.ranges[0] = (stp_psp_range){0, r->live};
    for (bool all = false; !all; ++c.depth) {
        assert(2 * (size_t)c.count <= maximum);
        stp_parallel_for(context, c.count, 1, split_some, &c);
        uint32_t kept = 0;
        all = true;
        for (uint32_t i = 0; i < 2 * c.count; ++i) {
            stp_psp_range of = c.next[i];
            if (of.end > of.begin) {
                assert(of.begin == (kept > 0 ? c.ranges[kept - 1].end : 0) && "no gaps");
                all = all && is_small(&c, of);
                c.ranges[kept++] = of;
            }
        }
        c.count = kept;
    }
    assert(c.count > 0 && c.ranges[c.count - 1].end == r->live);
    stp_free(context, c.next);
    *ranges = c.ranges;
    *count = c.count;
    return STP_OK;
}
