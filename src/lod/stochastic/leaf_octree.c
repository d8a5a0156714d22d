// SPDX-License-Identifier: MIT
#include "lod/stochastic/leaf_octree.h"

#include "base/math/rng.h"
#include "base/splats/leaf_codes.h"
#include "lod/stochastic/scatter.h"

#include <assert.h>
#include <string.h>

enum {
    BUDGET = 1024,
    LEAST = 48,
    SAMPLE = 256,
    SCALES = 2,
    NEIGHBOURS = 12,
    NORMAL_NEIGHBOURS = 20,
    STACK = 8 * STP_LEAF_DEPTH_MAX + 1,
    SIDES = 8,
};
#define FLATNESS 0.005f

stp_leaf_desc stp_leaf_desc_default(void)
{
    return (stp_leaf_desc){
        .budget = BUDGET,
        .minimum = LEAST,
        .flatness = FLATNESS,
        .neighbours = NEIGHBOURS,
        .normal_neighbours = NORMAL_NEIGHBOURS,
        .scales = SCALES,
        .sample = SAMPLE,
    };
}

/// A point while it is sorted into its leaf.
typedef struct placed_point {
    uint16_t at[3];
    uint16_t spare;
    uint32_t index;
} placed_point;

typedef struct octree_maker {
    stp_context* context;
    const stp_leaf_desc* desc;
    uint64_t seed;
    placed_point *points, *scratch;
    stp_leaf_octree* octree;
    size_t leaf_capacity;
} octree_maker;

/// Scatter of a cell's points: of all points if there are few, otherwise of a random sample (with
/// repetition).
static void scatter_of(const octree_maker* m, const stp_leaf_cell* cell, double matrix[6])
{
    assert(m->desc->sample > 0 && cell->begin < cell->end);
    uint32_t count = cell->end - cell->begin;
    uint32_t taken = count < m->desc->sample ? count : m->desc->sample;
    stp_scatter scatter = {0};
    for (uint32_t i = 0; i < taken; ++i) {
        uint32_t at = taken == count ? i : stp_rng_below(m->seed + cell->begin, i, count);
        const placed_point* p = &m->points[cell->begin + at];
        stp_scatter_add(&scatter, (double)p->at[0] - (double)cell->corner[0],
                        (double)p->at[1] - (double)cell->corner[1],
                        (double)p->at[2] - (double)cell->corner[2]);
    }
    stp_scatter_matrix(&scatter, matrix);
}

static bool is_leaf(const octree_maker* m, const stp_leaf_cell* cell)
{
    uint32_t count = cell->end - cell->begin;
    if (cell->depth == STP_LEAF_DEPTH_MAX || count <= m->desc->minimum) {
        return true;
    }
    if (count > m->desc->budget) {
        return false;
    }
    double matrix[6];
    scatter_of(m, cell, matrix);
    return stp_scatter_is_flat(matrix, (double)m->desc->flatness);
}

/// Octant of a cell at this depth that contains a position.
static uint32_t side_of(const uint16_t at[3], uint32_t depth)
{
    assert(depth < STP_LEAF_DEPTH_MAX);
    uint32_t shift = STP_LEAF_DEPTH_MAX - 1 - depth;
    return (at[0] >> shift & 1u) | (at[1] >> shift & 1u) << 1 | (at[2] >> shift & 1u) << 2;
}

/// Stably sorts the points of a cell by octant.
static void divide(octree_maker* m, const stp_leaf_cell* cell, uint32_t ends[SIDES])
{
    uint32_t counts[SIDES] = {0}, next[SIDES];
    for (uint32_t i = cell->begin; i < cell->end; ++i) {
        counts[side_of(m->points[i].at, cell->depth)] += 1;
    }
    uint32_t at = cell->begin;
    for (int s = 0; s < SIDES; ++s) {
        next[s] = at;
        at += counts[s];
        ends[s] = at;
    }
    assert(at == cell->end);
    for (uint32_t i = cell->begin; i < cell->end; ++i) {
        m->scratch[next[side_of(m->points[i].at, cell->depth)]++] = m->points[i];
    }
    memcpy(m->points + cell->begin, m->scratch + cell->begin,
           (size_t)(cell->end - cell->begin) * sizeof(*m->points));
}

static stp_result add_leaf(octree_maker* m, const stp_leaf_cell* leaf)
{
    stp_leaf_octree* octree = m->octree;
    assert(leaf->begin < leaf->end);
    assert(leaf->begin ==
           (octree->leaf_count > 0 ? octree->leaves[octree->leaf_count - 1].end : 0));
    assert(
        (octree->leaf_count == 0 || stp_leaf_morton(octree->leaves[octree->leaf_count - 1].corner) <
                                        stp_leaf_morton(leaf->corner)) &&
        "leaves ascend along the Morton curve");
    if (octree->leaf_count == m->leaf_capacity) {
        if (!STP_MAKE_ROOM(m->context, octree->leaves, m->leaf_capacity,
                           (size_t)octree->leaf_count + 1)) {
            return stp_fail_memory(m->context);
        }
    }
    octree->leaves[octree->leaf_count++] = *leaf;
    return STP_OK;
}

/// Divides cells depth first. The top of the stack is the next one along the curve.
static stp_result divide_all(octree_maker* m, uint32_t count)
{
    stp_leaf_cell stack[STACK];
    uint32_t height = 0;
    stp_result result = STP_OK;
    stack[height++] = (stp_leaf_cell){.begin = 0, .end = count};
    while (height > 0 && result == STP_OK) {
        stp_leaf_cell cell = stack[--height];
        if (is_leaf(m, &cell)) {
            result = add_leaf(m, &cell);
            continue;
        }
        uint32_t ends[SIDES];
        divide(m, &cell, ends);
        uint32_t half = stp_leaf_width(cell.depth + 1u);
        for (int s = SIDES; s-- > 0;) {
            stp_leaf_cell part = {.begin = s > 0 ? ends[s - 1] : cell.begin,
                                  .end = ends[s],
                                  .depth = (uint8_t)(cell.depth + 1)};
            for (int k = 0; k < 3; ++k) {
                part.corner[k] = (uint16_t)(cell.corner[k] + ((unsigned)s >> k & 1u) * half);
            }
            if (part.end > part.begin) {
                assert(height < STACK);
                stack[height++] = part;
            }
        }
    }
    assert(result != STP_OK || m->octree->leaves[m->octree->leaf_count - 1].end == count);
    return result;
}

/// Shuffles each leaf's points (Fisher and Yates). The order depends only on the leaf's first
/// index.
static void shuffle(const octree_maker* m)
{
    const stp_leaf_octree* octree = m->octree;
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        const stp_leaf_cell* leaf = &octree->leaves[l];
        uint32_t* order = octree->order + leaf->begin;
        uint32_t count = leaf->end - leaf->begin;
        for (uint32_t i = 0; i < count; ++i) {
            uint32_t with =
                stp_rng_below(m->seed ^ UINT64_C(0x5354), (uint64_t)leaf->begin + i, i + 1);
            assert(with <= i);
            order[i] = order[with];
            order[with] = m->points[leaf->begin + i].index;
        }
    }
}

stp_result stp_leaf_octree_make(stp_context* context, const uint16_t* positions, uint32_t count,
                                const stp_leaf_desc* desc, uint64_t seed, stp_leaf_octree* octree)
{
    *octree = (stp_leaf_octree){0};
    octree_maker m = {.context = context,
                      .desc = desc,
                      .seed = seed,
                      .points = STP_NEW_ARRAY(context, placed_point, (size_t)count + 1),
                      .scratch = STP_NEW_ARRAY(context, placed_point, (size_t)count + 1),
                      .octree = octree};
    octree->order = STP_NEW_ARRAY(context, uint32_t, (size_t)count + 1);
    stp_result result = STP_OK;
    if (m.points == NULL || m.scratch == NULL || octree->order == NULL) {
        result = stp_fail_memory(context);
    }
    for (uint32_t i = 0; i < count && result == STP_OK; ++i) {
        const uint16_t* p = positions + 3 * (size_t)i;
        m.points[i] = (placed_point){.at = {p[0], p[1], p[2]}, .index = i};
    }
    if (result == STP_OK && count > 0) {
        result = divide_all(&m, count);
    }
    if (result == STP_OK) {
        shuffle(&m);
    }
    stp_free(context, m.scratch);
    stp_free(context, m.points);
    return result;
}

void stp_leaf_octree_destroy(stp_context* context, stp_leaf_octree* octree)
{
    stp_free(context, octree->leaves);
    stp_free(context, octree->order);
    *octree = (stp_leaf_octree){0};
}
