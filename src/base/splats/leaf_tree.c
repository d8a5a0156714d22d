// SPDX-License-Identifier: MIT
#include "base/splats/leaf_tree.h"

#include "base/splats/leaf_codes.h"
#include "base/splats/leaf_runs.h"
#include "base/splats/octahedral.h"

#include <assert.h>

enum {
    STACK = 8 * (STP_LEAF_DEPTH_MAX + 1),
    RESERVED = 128, ///< bit of a leaf's `place` that must be 0
};

/// Leaves [begin, end) to be added to the tree.
typedef struct leaf_range {
    uint32_t begin, end;
} leaf_range;

static stp_leaf_node node_of_leaf(const stp_splat_leaf* leaf)
{
    float flatness = stp_min(stp_leaf_flatness(leaf->flatness), STP_LEAF_BENT);
    return (stp_leaf_node){.count = leaf->count,
                           .leaf_count = 1,
                           .area = stp_leaf_area(leaf),
                           .flatness = flatness,
                           .edge = (leaf->place & STP_LEAF_EDGE) != 0 ? 1.0f : 0.0f,
                           .edge_flatness = flatness,
                           .turn = (float)leaf->spread / 255.0f,
                           .corner = {leaf->corner[0], leaf->corner[1], leaf->corner[2]},
                           .depth = (uint8_t)stp_leaf_depth(leaf),
                           .normal = {leaf->normal[0], leaf->normal[1]},
                           .spread = leaf->spread};
}

/// Depth of the smallest cube that contains two different positions.
static uint32_t common_depth(uint64_t a, uint64_t b)
{
    assert(a != b);
    uint32_t bit = 63u - (uint32_t)__builtin_clzll(a ^ b);
    return STP_LEAF_DEPTH_MAX - 1 - bit / 3;
}

/// Pushes the leaves of each octant of a cube of this depth, last one first.
static uint32_t push_parts(const stp_splat_leaf* leaves, leaf_range range, uint32_t depth,
                           leaf_range* stack, uint32_t height)
{
    uint32_t shift = 3 * (STP_LEAF_DEPTH_MAX - 1 - depth);
    uint32_t end = range.end;
    while (end > range.begin) {
        uint64_t part = stp_leaf_morton(leaves[end - 1].corner) >> shift;
        uint32_t low = range.begin, high = end - 1; // the octant's first leaf is in [low, high]
        while (low < high) {
            uint32_t middle = low + (high - low) / 2;
            if (stp_leaf_morton(leaves[middle].corner) >> shift < part) {
                low = middle + 1;
            } else {
                high = middle;
            }
        }
        assert(height < STACK);
        stack[height++] = (leaf_range){low, end};
        end = low;
    }
    return height;
}

static stp_leaf_node node_of_cube(const stp_splat_leaf* leaves, leaf_range range, uint32_t depth)
{
    stp_leaf_node node = {.leaf_count = range.end - range.begin, .depth = (uint8_t)depth};
    for (int k = 0; k < 3; ++k) {
        uint32_t mask = ~(stp_leaf_width(depth) - 1);
        node.corner[k] = (uint16_t)(leaves[range.begin].corner[k] & mask);
    }
    return node;
}

/// Bounds the sine of the angle between a part's normals and another normal: the sum of two sines.
static float spread_to(const stp_leaf_node* part, stp_vec3 normal)
{
    stp_vec3 n = stp_octahedral_decode(part->normal[0], part->normal[1]);
    float cosine = stp_dot(n, normal);
    float sine = cosine > 0.0f ? sqrtf(stp_max(1.0f - cosine * cosine, 0.0f)) : 1.0f;
    return sine + (float)part->spread / 255.0f;
}

/// Sums up the children of a cube. They must be there.
static void sum_up(stp_leaf_node* nodes, uint32_t index)
{
    stp_leaf_node* node = &nodes[index];
    stp_vec3 sum = {0};
    for (uint32_t i = index + 1; i < node->next; i = nodes[i].next) {
        const stp_leaf_node* part = &nodes[i];
        stp_vec3 n = stp_octahedral_decode(part->normal[0], part->normal[1]);
        sum = stp_add(sum, stp_scale(n, part->area));
        node->count += part->count;
        node->area += part->area;
        node->flatness += part->area * part->flatness;
        node->edge += part->area * part->edge;
        node->edge_flatness += part->area * part->edge * part->edge_flatness;
        node->turn += part->area * part->turn;
    }
    float share = node->area > 0.0f ? 1.0f / node->area : 0.0f, spread = 0.0f;
    node->edge_flatness = node->edge > 0.0f ? node->edge_flatness / node->edge : 0.0f;
    node->edge *= share;
    node->flatness *= share;
    node->turn *= share;
    stp_vec3 normal = stp_normalize(sum);
    for (uint32_t i = index + 1; i < node->next; i = nodes[i].next) {
        spread = stp_max(spread, spread_to(&nodes[i], normal));
    }
    node->spread = (uint8_t)stp_min(spread * 255.0f + 0.5f, 255.0f);
    stp_octahedral_encode(normal, node->normal);
}

uint32_t stp_leaf_tree_make(const stp_splat_leaf* leaves, uint32_t leaf_count, stp_leaf_node* nodes)
{
    leaf_range stack[STACK];
    uint32_t height = 0, count = 0, place = 0;
    if (leaf_count > 0) {
        stack[height++] = (leaf_range){0, leaf_count};
    }
    while (height > 0) {
        leaf_range range = stack[--height];
        stp_leaf_node* node = &nodes[count];
        if (range.end - range.begin == 1) {
            *node = node_of_leaf(&leaves[range.begin]);
        } else {
            uint32_t depth = common_depth(stp_leaf_morton(leaves[range.begin].corner),
                                          stp_leaf_morton(leaves[range.end - 1].corner));
            *node = node_of_cube(leaves, range, depth);
            height = push_parts(leaves, range, depth, stack, height);
        }
        node->first = place;
        node->leaf = range.begin;
        place += range.end - range.begin == 1 ? leaves[range.begin].count : 0;
        count += 1;
    }
    for (uint32_t i = count; i-- > 0;) {
        uint32_t end = nodes[i].leaf + nodes[i].leaf_count, next = i + 1;
        while (next < count && nodes[next].leaf < end) {
            next = nodes[next].next;
        }
        assert(next > i && next <= count);
        nodes[i].next = next;
        if (nodes[i].leaf_count > 1) {
            sum_up(nodes, i);
        }
    }
    assert(count <= stp_leaf_tree_max_nodes(leaf_count));
    assert(count == 0 || (nodes[0].next == count && nodes[0].count == place));
    return count;
}

static bool is_leaf_sound(const stp_splat_leaf* leaf)
{
    uint32_t depth = stp_leaf_depth(leaf);
    bool sound = depth <= STP_LEAF_DEPTH_MAX && (leaf->place & RESERVED) == 0 && leaf->count > 0 &&
                 leaf->extent > 0;
    for (int k = 0; k < 3 && sound; ++k) {
        sound = (leaf->corner[k] & (stp_leaf_width(depth) - 1)) == 0;
    }
    return sound;
}

const char* stp_splat_leaves_fault(const stp_splats* set, const stp_splat_leaf* leaves,
                                   uint32_t leaf_count)
{
    uint64_t sum = 0, end = 0;
    for (uint32_t i = 0; i < leaf_count; ++i) {
        if (!is_leaf_sound(&leaves[i])) {
            return "a leaf is not a cube of the grid or has no splats";
        }
        uint64_t code = stp_leaf_morton(leaves[i].corner);
        if (code < end) {
            return "its leaves overlap or are out of order";
        }
        end = code + (UINT64_C(1) << 3 * (STP_LEAF_DEPTH_MAX - stp_leaf_depth(&leaves[i])));
        sum += leaves[i].count;
    }
    if (leaf_count == 0 || sum != set->count) {
        return "its leaves have a different number of splats in total";
    }
    bool fits = set->octave_count == stp_leaf_octaves(set->count);
    for (uint32_t k = 0; k < set->octave_count && fits; ++k) {
        fits = set->octave_ends[k] == stp_leaf_until(set->count, k, set->octave_count);
    }
    return fits ? NULL : "its octaves do not match its leaves";
}
