// SPDX-License-Identifier: MIT
#include "lod/stochastic/trim.h"

#include <math.h>
#include <string.h>

enum { STEPS = 100 }; ///< of bisection

static double count_of(const stp_leaf_octree* octree, uint32_t leaf)
{
    return (double)(octree->leaves[leaf].end - octree->leaves[leaf].begin);
}

/// Points that are kept where a square of the grid's step has `density` of them.
static double kept_at(const stp_leaf_octree* octree, const stp_leaf_facts* facts, double density)
{
    double sum = 0.0;
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        sum += fmin(density * (double)facts[l].area, count_of(octree, l));
    }
    return sum;
}

/// The density with which about `wanted` points are kept.
static double find_density(const stp_leaf_octree* octree, const stp_leaf_facts* facts,
                           uint32_t wanted)
{
    double low = 0.0, high = 0x1p-40;
    while (high < 0x1p80 && kept_at(octree, facts, high) < (double)wanted) {
        high *= 2.0;
    }
    for (int i = 0; i < STEPS; ++i) {
        double middle = 0.5 * (low + high);
        *(kept_at(octree, facts, middle) < (double)wanted ? &low : &high) = middle;
    }
    return high;
}

void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_facts* facts, uint32_t* ranked,
                   uint32_t wanted)
{
    double density = find_density(octree, facts, wanted), carried = 0.5;
    uint32_t leaves = 0, kept = 0, all = 0;
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        all += octree->leaves[l].end - octree->leaves[l].begin;
    }
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        stp_leaf_cell leaf = octree->leaves[l];
        uint32_t has = leaf.end - leaf.begin;
        carried += fmin(density * (double)facts[l].area, (double)has);
        uint32_t count = carried > 0.0 ? (uint32_t)fmin(floor(carried), (double)has) : 0;
        all -= has;
        uint32_t left = wanted - kept; // those behind may have too few, or none may be left
        count = count < left ? count : left;
        count = left - count > all ? left - all : count;
        carried -= (double)count;
        if (count > 0) {
            memmove(ranked + kept, ranked + leaf.begin, count * sizeof(*ranked));
            leaf.begin = kept;
            leaf.end = kept += count;
            facts[leaves] = facts[l];
            octree->leaves[leaves++] = leaf;
        }
    }
    octree->leaf_count = leaves;
}
