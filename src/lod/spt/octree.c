// SPDX-License-Identifier: MIT
#include "lod/spt/octree.h"

#include "base/core/sort.h"
#include "base/math/morton.h"

#include <assert.h>
#include <string.h>

enum {
    SORTED_LEVELS = 10, ///< upper levels, sorted in one pass over all points
    LEVELS = 40,        ///< maximum subdivisions; points that still coincide are split by order
    GRAIN = 16384,      ///< points
    BLOCK = 64,         ///< points processed per batch
    FEW = 32,           ///< maximum items of a box whose octants are cached
};

static stp_vec3d position_of(const stp_octree* o, uint32_t point)
{
    const float* p = o->positions + 3 * (size_t)point;
    return stp_to_double((stp_vec3){p[0], p[1], p[2]});
}

static uint32_t code_of(const stp_octree* o, uint32_t item)
{
    return (uint32_t)(o->items[item] >> 32);
}

static stp_octree_cell find_root(const stp_octree* o)
{
    stp_boxd box = stp_boxd_empty();
    for (uint32_t i = 0; i < o->count; ++i) {
        stp_boxd_add(&box, position_of(o, i));
    }
    stp_vec3d size = stp_subd(box.max, box.min);
    double half = 0.5 * fmax(size.x, fmax(size.y, size.z));
    return (stp_octree_cell){stp_scaled(stp_addd(box.min, box.max), 0.5), half > 0.0 ? half : 1.0};
}

static stp_octree_cell child_cell(const stp_octree_cell* cell, uint32_t octant)
{
    double half = 0.5 * cell->half;
    return (stp_octree_cell){{cell->center.x + ((octant & 1) != 0 ? half : -half),
                              cell->center.y + ((octant & 2) != 0 ? half : -half),
                              cell->center.z + ((octant & 4) != 0 ? half : -half)},
                             half};
}

/// Index of the octant that contains a point.
static uint32_t octant_of(const stp_octree_cell* cell, stp_vec3d p)
{
    return (p.x >= cell->center.x ? 1u : 0u) | (p.y >= cell->center.y ? 2u : 0u) |
           (p.z >= cell->center.z ? 4u : 0u);
}

/// Halves along one axis with the same rounding as child_cell(). Each halving yields one bit, the
/// first one highest.
static void find_places(const double at[BLOCK], double center, double half, uint32_t places[BLOCK])
{
    double centers[BLOCK], bits[BLOCK] = {0}; // as doubles: one vector format for all
    for (int i = 0; i < BLOCK; ++i) {
        centers[i] = center;
    }
    for (int level = 0; level < SORTED_LEVELS; ++level) {
        half *= 0.5;
        for (int i = 0; i < BLOCK; ++i) {
            double above = at[i] >= centers[i] ? 1.0 : 0.0;
            bits[i] = 2.0 * bits[i] + above;
            centers[i] += above * (2.0 * half) - half; // half up or down, without rounding
        }
    }
    for (int i = 0; i < BLOCK; ++i) {
        places[i] = (uint32_t)bits[i];
    }
}

static void find_items(size_t begin, size_t end, uint32_t worker, void* user)
{
    const stp_octree* o = user;
    (void)worker;
    for (size_t first = begin; first < end; first += BLOCK) {
        size_t count = end - first < BLOCK ? end - first : BLOCK;
        double at[3][BLOCK] = {{0}};
        uint32_t places[3][BLOCK];
        for (size_t i = 0; i < count; ++i) {
            for (size_t k = 0; k < 3; ++k) {
                at[k][i] = (double)o->positions[3 * (first + i) + k];
            }
        }
        find_places(at[0], o->root.center.x, o->root.half, places[0]);
        find_places(at[1], o->root.center.y, o->root.half, places[1]);
        find_places(at[2], o->root.center.z, o->root.half, places[2]);
        for (size_t i = 0; i < count; ++i) {
            uint64_t code = stp_morton(places[0][i], places[1][i], places[2][i]);
            assert(code >> 3 * SORTED_LEVELS == 0 && "the sort reads these bits only");
            o->items[first + i] = code << 32 | (first + i);
        }
    }
}

stp_result stp_octree_make(stp_context* context, const float* positions, uint32_t count,
                           stp_octree* octree)
{
    assert(count > 0);
    *octree = (stp_octree){
        .positions = positions,
        .count = count,
        .items = STP_NEW_ARRAY(context, uint64_t, count),
        .scratch = STP_NEW_ARRAY(context, uint64_t, count),
    };
    uint64_t* sorted = NULL;
    if (octree->items != NULL && octree->scratch != NULL) {
        octree->root = find_root(octree);
        stp_parallel_for(context, count, GRAIN, find_items, octree);
        sorted = stp_parallel_sort_u64(context, octree->items, octree->scratch, count, 32,
                                       3 * SORTED_LEVELS);
    }
    if (sorted == NULL) {
        return stp_fail_memory(context);
    }
    if (sorted != octree->items) {
        octree->scratch = octree->items;
        octree->items = sorted;
    }
    return STP_OK;
}

void stp_octree_destroy(stp_context* context, stp_octree* octree)
{
    stp_free(context, octree->items);
    stp_free(context, octree->scratch);
    *octree = (stp_octree){0};
}

/// Cell of the lowest sorted level, by its code.
static stp_octree_cell find_cell(const stp_octree* o, uint32_t code)
{
    stp_octree_cell cell = o->root;
    for (int level = SORTED_LEVELS - 1; level >= 0; --level) {
        cell = child_cell(&cell, code >> 3 * level & 7u);
    }
    return cell;
}

/// End of the run of items whose code matches the first one's above bit `shift`.
static uint32_t find_end(const stp_octree* o, uint32_t begin, uint32_t end, uint32_t shift)
{
    uint32_t first = code_of(o, begin) >> shift, step = 1;
    while (end - begin > step && code_of(o, begin + step) >> shift == first) {
        begin += step;
        step *= 2;
    }
    uint32_t low = begin + 1, high = end - begin > step ? begin + step : end;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (code_of(o, middle) >> shift == first) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    assert(begin < low && low <= end);
    return low;
}

static uint32_t divide_sorted(const stp_octree* o, const stp_octree_box* box, uint32_t differing,
                              stp_octree_box children[8])
{
    uint32_t shift = (31u - (uint32_t)__builtin_clz(differing)) / 3 * 3, count = 0;
    for (uint32_t begin = box->begin; begin < box->end; begin = children[count - 1].end) {
        uint32_t end = find_end(o, begin, box->end, shift);
        assert(count < 8 && "codes differ in one octant only");
        children[count++] = (stp_octree_box){begin, end, SORTED_LEVELS - shift / 3, o->root};
    }
    assert(count >= 2 && children[count - 1].end == box->end);
    return count;
}

/// Groups items by octant: octant k is begins[k] to begins[k + 1].
/// @return number of nonempty octants
static uint32_t split(const stp_octree* o, const stp_octree_box* box, uint32_t begins[9])
{
    uint8_t octants[FEW]; // cached, because positions are scattered in memory
    bool few = box->end - box->begin <= FEW;
    uint32_t counts[8] = {0}, filled = 0;
    for (uint32_t i = box->begin; i < box->end; ++i) {
        uint32_t octant = octant_of(&box->cell, position_of(o, stp_octree_point(o, i)));
        counts[octant] += 1;
        if (few) {
            octants[i - box->begin] = (uint8_t)octant;
        }
    }
    begins[0] = box->begin;
    for (uint32_t k = 0; k < 8; ++k) {
        begins[k + 1] = begins[k] + counts[k];
        filled += counts[k] > 0;
        counts[k] = begins[k];
    }
    assert(begins[8] == box->end && "each item is in an octant");
    if (filled > 1) {
        for (uint32_t i = box->begin; i < box->end; ++i) {
            uint32_t octant = few ? octants[i - box->begin]
                                  : octant_of(&box->cell, position_of(o, stp_octree_point(o, i)));
            o->scratch[counts[octant]++] = o->items[i];
        }
        memcpy(o->items + box->begin, o->scratch + box->begin,
               (box->end - box->begin) * sizeof(*o->items));
    }
    return filled;
}

uint32_t stp_octree_divide(const stp_octree* octree, stp_octree_box box, stp_octree_box children[8])
{
    assert(box.end <= octree->count && box.end - box.begin >= 2);
    if (box.level <= SORTED_LEVELS) {
        uint32_t code = code_of(octree, box.begin);
        uint32_t differing = code ^ code_of(octree, box.end - 1);
        if (differing != 0) {
            return divide_sorted(octree, &box, differing, children);
        }
        box.level = SORTED_LEVELS;
        box.cell = find_cell(octree, code);
    }
    uint32_t begins[9], filled = 1, count = 0;
    while (filled == 1 && box.level < LEVELS) {
        filled = split(octree, &box, begins);
        if (filled == 1) {
            uint32_t octant = 0;
            while (begins[octant + 1] == box.begin) {
                octant += 1;
            }
            box.cell = child_cell(&box.cell, octant);
            box.level += 1;
        }
    }
    for (uint32_t k = 0; k <= 8 && filled == 1; ++k) { // points coincide, or nearly so
        begins[k] = box.begin + (uint32_t)((uint64_t)(box.end - box.begin) * k / 8);
    }
    for (uint32_t k = 0; k < 8; ++k) {
        if (begins[k + 1] > begins[k]) {
            children[count++] =
                (stp_octree_box){begins[k], begins[k + 1], box.level + 1, child_cell(&box.cell, k)};
        }
    }
    assert(count >= 2 && children[0].begin == box.begin && children[count - 1].end == box.end);
    return count;
}
