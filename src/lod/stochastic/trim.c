// SPDX-License-Identifier: MIT
#include "lod/stochastic/leaf_passes.h"

#include <assert.h>
#include <math.h>
#include <string.h>

enum { ROUNDS_MAX = 64 };

static double count_of(const stp_leaf_octree* octree, uint32_t leaf)
{
    return (double)(octree->leaves[leaf].end - octree->leaves[leaf].begin);
}

/// Number of points per square grid step that keeps about `wanted` in total. Leaves with fewer keep
/// all of them, and the others share the rest; this repeats until no more leaves run short.
static double find_density(const stp_leaf_octree* octree, const stp_leaf_properties* properties,
                           double wanted)
{
    double density = 0.0;
    bool grows = true;
    for (int round = 0; round < ROUNDS_MAX && grows; ++round) {
        double given = 0.0, area = 0.0;
        for (uint32_t l = 0; l < octree->leaf_count; ++l) {
            bool all = density * (double)properties[l].area >= count_of(octree, l);
            given += all ? count_of(octree, l) : 0.0;
            area += all ? 0.0 : (double)properties[l].area;
        }
        double next = area > 0.0 ? (wanted - given) / area : density;
        grows = next > density;
        density = grows ? next : density;
    }
    return density;
}

void stp_leaf_trim(stp_leaf_octree* octree, stp_leaf_properties* properties, uint32_t* ranked,
                   uint32_t wanted)
{
    double density = find_density(octree, properties, (double)wanted), carried = 0.5;
    uint32_t leaves = 0, kept = 0, all = 0;
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        all += octree->leaves[l].end - octree->leaves[l].begin;
    }
    assert(wanted < all);
    for (uint32_t l = 0; l < octree->leaf_count; ++l) {
        stp_leaf_cell leaf = octree->leaves[l];
        uint32_t has = leaf.end - leaf.begin;
        carried += fmin(density * (double)properties[l].area, (double)has);
        uint32_t count = carried > 0.0 ? (uint32_t)fmin(floor(carried), (double)has) : 0;
        all -= has;
        uint32_t left = wanted - kept; // later leaves may have too few, or none may be left
        count = count < left ? count : left;
        count = left - count > all ? left - all : count;
        assert(count <= has && count <= left && left - count <= all);
        carried -= (double)count;
        assert(kept <= leaf.begin && leaves <= l && "points and leaves only move forward");
        if (count > 0) {
            memmove(ranked + kept, ranked + leaf.begin, count * sizeof(*ranked));
            leaf.begin = kept;
            leaf.end = kept += count;
            properties[leaves] = properties[l];
            octree->leaves[leaves++] = leaf;
        }
    }
    assert(kept == wanted && all == 0);
    octree->leaf_count = leaves;
}
