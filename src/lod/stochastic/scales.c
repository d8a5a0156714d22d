// SPDX-License-Identifier: MIT
#include "base/splats/leaf_codes.h"
#include "lod/stochastic/leaf_passes.h"

#include <assert.h>

enum { GRAIN = 256 }; ///< leaves
#define PERSISTS 0.5  // minimum ratio of flatness to that of the scale below, for a persistent edge

typedef struct scale_loop {
    const stp_leaf_octree* octree;
    const stp_scatter* scatters;
    uint32_t scales;
    stp_leaf_properties* properties;
} scale_loop;

/// The last measured cube of each depth. Leaves of a cube are consecutive.
typedef struct cube_memory {
    uint64_t codes[STP_LEAF_DEPTH_MAX + 1];
    float flatness[STP_LEAF_DEPTH_MAX + 1];
    bool known[STP_LEAF_DEPTH_MAX + 1];
} cube_memory;

/// First leaf whose Morton code is at least `code`.
static uint32_t find_leaf(const stp_leaf_octree* octree, uint64_t code)
{
    uint32_t low = 0, high = octree->leaf_count;
    while (low < high) {
        uint32_t middle = low + (high - low) / 2;
        if (stp_leaf_morton(octree->leaves[middle].corner) < code) {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    assert(low == octree->leaf_count || stp_leaf_morton(octree->leaves[low].corner) >= code);
    return low;
}

/// Flatness of all points in the cube of this depth around a leaf.
static float measure_cube(const scale_loop* l, const stp_leaf_cell* leaf, uint32_t depth)
{
    uint32_t shift = 3 * (STP_LEAF_DEPTH_MAX - depth);
    uint64_t begin = stp_leaf_morton(leaf->corner) >> shift << shift;
    uint64_t end = begin + (UINT64_C(1) << shift);
    uint32_t mask = ~(stp_leaf_width(depth) - 1);
    stp_scatter sum = {0};
    for (uint32_t i = find_leaf(l->octree, begin); i < l->octree->leaf_count; ++i) {
        const stp_leaf_cell* part = &l->octree->leaves[i];
        if (stp_leaf_morton(part->corner) >= end) {
            break;
        }
        const double from[3] = {(double)(part->corner[0] - (leaf->corner[0] & mask)),
                                (double)(part->corner[1] - (leaf->corner[1] & mask)),
                                (double)(part->corner[2] - (leaf->corner[2] & mask))};
        double points = (double)(part->end - part->begin);
        assert((part->corner[0] & mask) == (leaf->corner[0] & mask) &&
               (part->corner[1] & mask) == (leaf->corner[1] & mask) &&
               (part->corner[2] & mask) == (leaf->corner[2] & mask) &&
               "leaves of a cube are consecutive");
        assert(l->scatters[i].count > 0.0);
        stp_scatter_merge(&sum, &l->scatters[i], points / l->scatters[i].count, from);
    }
    assert(sum.count > 0.0 && "the cube holds the leaf itself");
    double matrix[6];
    stp_scatter_matrix(&sum, matrix);
    return (float)stp_scatter_flatness(matrix);
}

static float flatness_of_cube(const scale_loop* l, cube_memory* memory, const stp_leaf_cell* leaf,
                              uint32_t depth)
{
    uint64_t code = stp_leaf_morton(leaf->corner) >> 3 * (STP_LEAF_DEPTH_MAX - depth);
    if (!memory->known[depth] || memory->codes[depth] != code) {
        memory->flatness[depth] = measure_cube(l, leaf, depth);
        memory->codes[depth] = code;
        memory->known[depth] = true;
    }
    return memory->flatness[depth];
}

static void limit_some(size_t begin, size_t end, uint32_t worker, void* user)
{
    (void)worker;
    const scale_loop* l = user;
    cube_memory memory = {.known = {false}};
    for (size_t i = begin; i < end; ++i) {
        const stp_leaf_cell* leaf = &l->octree->leaves[i];
        stp_leaf_properties* f = &l->properties[i];
        float last = f->flatness;
        for (uint32_t up = 1; up < l->scales && up <= leaf->depth; ++up) {
            float next = flatness_of_cube(l, &memory, leaf, leaf->depth - up);
            f->edge = f->edge && next >= (float)PERSISTS * last;
            f->min_flatness = stp_min(f->min_flatness, next);
            last = next;
        }
    }
}

void stp_leaf_measure_scales(stp_context* context, const stp_leaf_octree* octree,
                             const stp_scatter* scatters, uint32_t scales,
                             stp_leaf_properties* properties)
{
    assert(scales <= STP_LEAF_SCALES_MAX);
    scale_loop loop = {octree, scatters, scales, properties};
    if (scales > 1) {
        stp_parallel_for(context, octree->leaf_count, GRAIN, limit_some, &loop);
    }
}
