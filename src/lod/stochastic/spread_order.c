// SPDX-License-Identifier: MIT
#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "lod/stochastic/leaf_passes.h"

#include <assert.h>
#include <string.h>

enum {
    GRAIN = 16, ///< leaves
    /// Maximum points spread together; larger leaves are processed in blocks
    BLOCK = 2048,
    SHARE = 4, ///< one in this many points is spread
    LEAST = 4, ///< with at most this many points, any order is good enough
    WIDE = 16, ///< distances compared together
};

/// Points of a leaf. The cube's side is scaled to 16 bits, so that differences wrap around at
/// opposite sides.
typedef struct spread_block {
    int16_t at[3][BLOCK];
    /// Squared distance to the nearest chosen point, over 2^17; -1: chosen itself
    int16_t far[BLOCK];
    uint32_t index[BLOCK];
    uint32_t count;
} spread_block;

typedef struct spread_loop {
    const uint16_t* positions;
    const stp_leaf_octree* octree;
    const uint32_t* from;
    uint32_t* to;
    uint32_t count, octaves;
} spread_loop;

static void take_points(spread_block* b, const spread_loop* l, const stp_leaf_cell* leaf,
                        uint32_t begin)
{
    b->count = leaf->end - begin < BLOCK ? leaf->end - begin : BLOCK;
    memcpy(b->index, l->octree->order + begin, b->count * sizeof(*b->index));
    for (uint32_t i = 0; i < b->count; ++i) {
        const uint16_t* p = l->positions + 3 * (size_t)b->index[i];
        for (int k = 0; k < 3; ++k) {
            assert((uint32_t)(p[k] - leaf->corner[k]) < stp_leaf_width(leaf->depth));
            uint32_t wide = (uint32_t)(p[k] - leaf->corner[k]) << leaf->depth;
            b->at[k][i] = (int16_t)(int32_t)((wide & 0xFFFFu) - 0x8000u);
        }
        b->far[i] = INT16_MAX;
    }
    for (uint32_t i = b->count; i % WIDE != 0; ++i) {
        b->far[i] = -1;
    }
}

/// Lowers the distances of all points to include a chosen one. @return the largest remaining
/// distance
static int16_t choose_point(spread_block* b, uint32_t chosen)
{
    assert(b->far[chosen] >= 0 && "each point is chosen once");
    int16_t x = b->at[0][chosen], y = b->at[1][chosen], z = b->at[2][chosen], maximum = -1;
    b->far[chosen] = -1;
    for (uint32_t i = 0; i < b->count; ++i) {
        int16_t dx = (int16_t)(b->at[0][i] - x), dy = (int16_t)(b->at[1][i] - y);
        int16_t dz = (int16_t)(b->at[2][i] - z);
        int16_t xx = (int16_t)((int32_t)dx * dx >> 16), yy = (int16_t)((int32_t)dy * dy >> 16);
        int16_t zz = (int16_t)((int32_t)dz * dz >> 16);
        // at most 3 times 2^14
        uint16_t sum = (uint16_t)((uint16_t)xx + (uint16_t)yy + (uint16_t)zz);
        int16_t d = (int16_t)(sum >> 1);
        int16_t far = b->far[i] < d ? b->far[i] : d;
        b->far[i] = far;
        maximum = far > maximum ? far : maximum;
    }
    return maximum;
}

/// First point at a distance that some point has.
static uint32_t find_first(const spread_block* b, int16_t far)
{
    uint32_t i = 0;
    for (bool found = false; !found; i += WIDE) {
        for (uint32_t k = 0; k < WIDE; ++k) {
            found |= b->far[i + k] == far;
        }
    }
    for (i -= WIDE; b->far[i] != far; ++i) {
    }
    assert(i < b->count);
    return i;
}

/// The point nearest to the mean.
static uint32_t find_middle(const spread_block* b)
{
    int64_t mean[3] = {0}, minimum = INT64_MAX;
    uint32_t best = 0;
    for (int k = 0; k < 3; ++k) {
        for (uint32_t i = 0; i < b->count; ++i) {
            mean[k] += b->at[k][i];
        }
        mean[k] /= (int64_t)b->count;
    }
    for (uint32_t i = 0; i < b->count; ++i) {
        int64_t squared = 0;
        for (int k = 0; k < 3; ++k) {
            int64_t d = b->at[k][i] - mean[k];
            squared += d * d;
        }
        best = squared < minimum ? i : best;
        minimum = squared < minimum ? squared : minimum;
    }
    return best;
}

/// @param ranked receives the points of the block
static void spread_points(spread_block* b, uint32_t* ranked)
{
    uint32_t maximum = b->count / SHARE < STP_SPREAD_MAX ? b->count / SHARE : STP_SPREAD_MAX;
    uint32_t done = 0;
    if (b->count > LEAST) {
        uint32_t next = find_middle(b);
        for (int16_t far = 1; done < maximum && far > 0; ++done) {
            ranked[done] = b->index[next];
            far = choose_point(b, next);
            next = far > 0 ? find_first(b, far) : 0;
        }
    }
    for (uint32_t i = 0; i < b->count; ++i) {
        if (b->far[i] >= 0) {
            ranked[done++] = b->index[i];
        }
    }
    assert(done == b->count && "ranks are a permutation");
}

static void spread_leaves(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const spread_loop* l = user;
    spread_block block;
    for (size_t i = begin; i < end; ++i) {
        const stp_leaf_cell* leaf = &l->octree->leaves[i];
        for (uint32_t at = leaf->begin; at < leaf->end; at += block.count) {
            take_points(&block, l, leaf, at);
            spread_points(&block, l->to + at);
        }
    }
}

void stp_spread_order_make(stp_context* context, const uint16_t* positions,
                           const stp_leaf_octree* octree, uint32_t* ranked)
{
    spread_loop loop = {.positions = positions, .octree = octree, .to = ranked};
    stp_parallel_for(context, octree->leaf_count, GRAIN, spread_leaves, &loop);
}

/// Converts ranks to places of a leaf, octave by octave.
static void place_leaves(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const spread_loop* l = user;
    for (size_t i = begin; i < end; ++i) {
        const stp_leaf_cell* leaf = &l->octree->leaves[i];
        const uint32_t* next = l->from + leaf->begin;
        for (uint32_t octave = 0; octave < l->octaves; ++octave) {
            uint32_t step = 1u << 2 * (l->octaves - 1 - octave);
            // places count from 1
            uint32_t place = (leaf->begin + step) / step * step;
            for (; place <= leaf->end; place += step) {
                if (stp_leaf_octave_of(place, l->octaves) == octave) {
                    l->to[place - 1] = *next++;
                }
            }
        }
        assert(next == l->from + leaf->end && "each place belongs to one octave");
    }
}

void stp_spread_order_place(stp_context* context, const uint32_t* ranked, uint32_t count,
                            stp_leaf_octree* octree)
{
    spread_loop loop = {
        .octree = octree, .from = ranked, .to = octree->order, .octaves = stp_leaf_octaves(count)};
    stp_parallel_for(context, octree->leaf_count, GRAIN, place_leaves, &loop);
}
