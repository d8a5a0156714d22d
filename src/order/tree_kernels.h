// SPDX-License-Identifier: MIT
//
// Tree kernels, written over the names of a vector_*.h and compiled once per instruction set. The
// includer defines KERNELS, the name of the table.
#include "order/tree.h"

#include <assert.h>
#include <math.h>

#define DISTANT INFINITY

typedef struct point_eight {
    eight x, y, z;
} point_eight;

static inline uint32_t lowest_bit(uint32_t mask)
{
    assert(mask != 0 && "a lane");
    return (uint32_t)__builtin_ctz(mask);
}

// Distance from a coordinate to an interval.
static inline eight outside(eight low, eight high, eight at)
{
    return eight_max(eight_set(0.0f), eight_max(eight_sub(low, at), eight_sub(at, high)));
}

// Squared distance from a point to the farthest corner of each child's box, an upper bound for its
// points.
static inline eight farthest_corner(const stp_branch* branch, point_eight at)
{
    eight x = eight_max(eight_sub(at.x, eight_load(branch->low_x)),
                        eight_sub(eight_load(branch->high_x), at.x));
    eight y = eight_max(eight_sub(at.y, eight_load(branch->low_y)),
                        eight_sub(eight_load(branch->high_y), at.y));
    eight z = eight_max(eight_sub(at.z, eight_load(branch->low_z)),
                        eight_sub(eight_load(branch->high_z), at.z));
    return eight_add(eight_add(eight_mul(x, x), eight_mul(y, y)), eight_mul(z, z));
}

// The gaps of the children; in `mask`, lowered to the upper bound that the point implies.
static inline eight bound_gaps(const stp_branch* branch, eight gap, point_eight at, uint32_t mask)
{
    return eight_blend(gap, eight_min(gap, farthest_corner(branch, at)), mask);
}

// The children that a point at `at` may change.
static inline uint32_t reached(const stp_branch* branch, eight gap, point_eight at)
{
    eight x = outside(eight_load(branch->low_x), eight_load(branch->high_x), at.x);
    eight y = outside(eight_load(branch->low_y), eight_load(branch->high_y), at.y);
    eight z = outside(eight_load(branch->low_z), eight_load(branch->high_z), at.z);
    eight squared = eight_add(eight_add(eight_mul(x, x), eight_mul(y, y)), eight_mul(z, z));
    return eight_less(squared, gap);
}

static inline point_eight spread(const stp_chosen* point)
{
    return (point_eight){eight_set(point->x), eight_set(point->y), eight_set(point->z)};
}

static inline wide squared_distance(wide x, wide y, wide z, const stp_chosen* point)
{
    wide dx = wide_sub(x, wide_set(point->x));
    wide dy = wide_sub(y, wide_set(point->y));
    wide dz = wide_sub(z, wide_set(point->z));
    return wide_add(wide_add(wide_mul(dx, dx), wide_mul(dy, dy)), wide_mul(dz, dz));
}

// The lanes whose normals face away from the point's.
static inline uint32_t facing_away(const stp_leaf_normals* normals, int i, const stp_chosen* point)
{
    wide x = wide_mul(wide_load(normals->x + i), wide_set(point->normal_x));
    wide y = wide_mul(wide_load(normals->y + i), wide_set(point->normal_y));
    wide z = wide_mul(wide_load(normals->z + i), wide_set(point->normal_z));
    return wide_less(wide_add(wide_add(x, y), z), wide_set(0.0f));
}

// Squared dissimilarity: (distance + side_penalty)^2 in the lanes of `away`. Square roots are
// correctly rounded on every CPU.
static inline wide squared_side_aware(wide squared, uint32_t away, float side_penalty)
{
    wide distance = wide_add(wide_root(squared), wide_set(side_penalty));
    return wide_blend(squared, wide_mul(distance, distance), away);
}

// Applies the pending points of a leaf to its gaps; `gap` is an upper bound of them.
// @return the largest
static float catch_up(const stp_tree* tree, uint32_t index, const stp_chosen* chosen, float gap)
{
    stp_leaf* leaf = &tree->leaves[index];
    stp_pending* pending = &tree->pending[index];
    uint32_t count = pending->count, mixed = pending->mixed;
    assert(count <= STP_PENDING_SIZE && mixed >> count == 0);
    assert(mixed == 0 || tree->normals != NULL);
    wide maximum = wide_set(-1.0f);
    for (int i = 0; i < STP_LEAF_SIZE; i += WIDE) {
        wide x = wide_load(leaf->x + i), y = wide_load(leaf->y + i), z = wide_load(leaf->z + i);
        wide gaps = wide_load(leaf->gap + i);
        for (uint32_t k = 0; k < count; ++k) {
            const stp_chosen* point = &chosen[pending->chosen[k]];
            wide squared = squared_distance(x, y, z, point);
            if ((mixed >> k & 1) != 0) {
                uint32_t away = facing_away(&tree->normals[index], i, point);
                squared = gap > tree->side_penalty_squared
                              ? squared_side_aware(squared, away, tree->side_penalty)
                              : wide_blend(squared, wide_set(DISTANT), away);
            }
            gaps = wide_min(gaps, squared);
        }
        wide_store(leaf->gap + i, gaps);
        maximum = wide_max(maximum, gaps);
    }
    pending->count = 0;
    pending->mixed = 0;
    return wide_highest(maximum);
}

// Removes from `mask` the leaves that face away as a whole and already have a nearer point that
// does not. Sets in `mixed` the leaves whose normals need individual tests.
static inline uint32_t exclude_facing(const stp_tree* tree, const stp_facing* facing, eight gap,
                                      const stp_chosen* point, uint32_t mask, uint32_t* mixed)
{
    eight normal_x = eight_set(point->normal_x), normal_y = eight_set(point->normal_y),
          normal_z = eight_set(point->normal_z);
    eight x0 = eight_mul(eight_load(facing->low_x), normal_x);
    eight x1 = eight_mul(eight_load(facing->high_x), normal_x);
    eight y0 = eight_mul(eight_load(facing->low_y), normal_y);
    eight y1 = eight_mul(eight_load(facing->high_y), normal_y);
    eight z0 = eight_mul(eight_load(facing->low_z), normal_z);
    eight z1 = eight_mul(eight_load(facing->high_z), normal_z);
    eight maximum = eight_add(eight_add(eight_max(x0, x1), eight_max(y0, y1)), eight_max(z0, z1));
    eight minimum = eight_add(eight_add(eight_min(x0, x1), eight_min(y0, y1)), eight_min(z0, z1));
    uint32_t all_away = eight_less(maximum, eight_set(0.0f));
    uint32_t waiting = eight_less(eight_set(tree->side_penalty_squared), gap);
    *mixed = eight_less(minimum, eight_set(0.0f));
    return mask & ~(all_away & ~waiting);
}

// Prefetches. Most of the time is spent waiting for leaves.
static inline void prefetch_bytes(const void* from, size_t size)
{
    for (size_t i = 0; i < size; i += 64) {
        __builtin_prefetch((const char*)from + i, 1);
    }
}

static inline void prefetch_leaf(const stp_tree* tree, uint32_t leaf)
{
    if (tree->pending[leaf].count != 0) {
        prefetch_bytes(&tree->leaves[leaf], sizeof(stp_leaf));
        if (tree->pending[leaf].mixed != 0) {
            prefetch_bytes(&tree->normals[leaf], sizeof(stp_leaf_normals));
        }
    } else {
        prefetch_bytes(&tree->leaves[leaf].gap, sizeof(tree->leaves[leaf].gap));
    }
}

static void push_to_leaves(stp_tree* tree, uint32_t index, const stp_chosen* chosen,
                           const uint32_t* list, uint32_t count)
{
    stp_branch* branch = &tree->levels[0][index];
    const stp_facing* facing = tree->facing != NULL ? &tree->facing[index] : NULL;
    eight gap = eight_load(branch->gap); // in a register: the next point depends on it
    for (uint32_t i = 0; i < count; ++i) {
        const stp_chosen* point = &chosen[list[i]];
        uint32_t mask = reached(branch, gap, spread(point)), mixed = 0;
        if (facing != NULL && mask != 0) {
            mask = exclude_facing(tree, facing, gap, point, mask, &mixed);
        }
        if (mask != 0) {
            gap = bound_gaps(branch, gap, spread(point), mask & ~mixed);
        }
        for (; mask != 0; mask &= mask - 1) {
            uint32_t child = lowest_bit(mask), leaf = index * STP_BRANCH_SIZE + child;
            stp_pending* pending = &tree->pending[leaf];
            assert(leaf < tree->leaf_count && pending->count < STP_PENDING_SIZE);
            uint32_t at = pending->count++;
            pending->chosen[at] = list[i];
            if ((mixed >> child & 1) != 0) {
                pending->mixed = (uint16_t)(pending->mixed | 1u << at);
            }
            if (at + 1 == STP_PENDING_SIZE) {
                eight_store(branch->gap, gap);
                branch->gap[child] = catch_up(tree, leaf, chosen, branch->gap[child]);
                gap = eight_load(branch->gap);
            }
        }
    }
    eight_store(branch->gap, gap);
}

static void push(stp_tree* tree, uint32_t level, uint32_t index, const stp_chosen* chosen,
                 const uint32_t* list, uint32_t count, uint32_t* scratch)
{
    if (level == 0) {
        push_to_leaves(tree, index, chosen, list, count);
        return;
    }
    assert(level < tree->level_count && index < tree->level_sizes[level]);
    stp_branch* branch = &tree->levels[level][index];
    uint32_t counts[STP_BRANCH_SIZE] = {0};
    eight gap = eight_load(branch->gap);
    for (uint32_t i = 0; i < count; ++i) {
        uint32_t mask = reached(branch, gap, spread(&chosen[list[i]]));
        if (tree->normals == NULL && mask != 0) {
            gap = bound_gaps(branch, gap, spread(&chosen[list[i]]), mask);
        }
        for (; mask != 0; mask &= mask - 1) {
            uint32_t child = lowest_bit(mask);
            scratch[(size_t)child * count + counts[child]++] = list[i];
        }
    }
    for (uint32_t child = 0; child < STP_BRANCH_SIZE && level == 1; ++child) {
        if (counts[child] != 0) {
            uint32_t below = index * STP_BRANCH_SIZE + child;
            prefetch_bytes(&tree->levels[0][below], sizeof(stp_branch));
            prefetch_bytes(&tree->pending[(size_t)below * STP_BRANCH_SIZE],
                           STP_BRANCH_SIZE * sizeof(stp_pending));
        }
    }
    eight_store(branch->gap, gap);
    uint32_t* deeper = scratch + (size_t)STP_BRANCH_SIZE * count;
    for (uint32_t child = 0; child < STP_BRANCH_SIZE; ++child) {
        if (counts[child] != 0) {
            push(tree, level - 1, index * STP_BRANCH_SIZE + child, chosen,
                 scratch + (size_t)child * count, counts[child], deeper);
        }
    }
}

static uint32_t collect_leaf(const stp_leaf* leaf, uint32_t first, float floor, uint32_t* positions)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < STP_LEAF_SIZE; i += WIDE) {
        uint32_t below = wide_less(wide_load(leaf->gap + i), wide_set(floor));
        for (uint32_t mask = ~below & ((1u << WIDE) - 1); mask != 0; mask &= mask - 1) {
            positions[count++] = first + i + lowest_bit(mask);
        }
    }
    return count;
}

// Collects from the leaves below a few neighbouring branches of level 0. Prefetches their pending
// lines first, then a few leaves ahead of the current one.
static uint32_t collect_leaves(stp_tree* tree, uint32_t first, uint32_t count,
                               const stp_chosen* chosen, float floor, uint32_t* positions)
{
    enum { AHEAD = 4 };
    uint32_t leaves[STP_BRANCH_SIZE * STP_BRANCH_SIZE], leaf_count = 0, found = 0;
    for (uint32_t index = first; index < first + count; ++index) {
        uint32_t below = eight_less(eight_load(tree->levels[0][index].gap), eight_set(floor));
        for (uint32_t mask = ~below & 0xFF; mask != 0; mask &= mask - 1) {
            leaves[leaf_count] = index * STP_BRANCH_SIZE + lowest_bit(mask);
            __builtin_prefetch(&tree->pending[leaves[leaf_count++]], 1);
        }
    }
    for (uint32_t i = 0; i < leaf_count + AHEAD; ++i) {
        if (i < leaf_count) {
            prefetch_leaf(tree, leaves[i]);
        }
        if (i < AHEAD) {
            continue;
        }
        uint32_t leaf = leaves[i - AHEAD];
        assert(leaf < tree->leaf_count && "missing children have no gap");
        float* gap = &tree->levels[0][leaf / STP_BRANCH_SIZE].gap[leaf % STP_BRANCH_SIZE];
        if (tree->pending[leaf].count != 0) {
            *gap = catch_up(tree, leaf, chosen, *gap);
        }
        if (*gap >= floor) {
            found +=
                collect_leaf(&tree->leaves[leaf], leaf * STP_LEAF_SIZE, floor, positions + found);
        }
    }
    return found;
}

static uint32_t collect(stp_tree* tree, uint32_t level, uint32_t index, const stp_chosen* chosen,
                        float floor, uint32_t* positions)
{
    assert(floor > 0.0f && index < tree->level_sizes[level]);
    if (level == 0) {
        return collect_leaves(tree, index, 1, chosen, floor, positions);
    }
    stp_branch* branch = &tree->levels[level][index];
    uint32_t below = index * STP_BRANCH_SIZE, size = tree->level_sizes[level - 1], count = 0;
    uint32_t mask = ~eight_less(eight_load(branch->gap), eight_set(floor)) & 0xFF;
    if (mask == 0) {
        return 0;
    }
    if (level == 1) {
        size = size - below < STP_BRANCH_SIZE ? size - below : STP_BRANCH_SIZE;
        count = collect_leaves(tree, below, size, chosen, floor, positions);
        mask = (1u << size) - 1;
    }
    for (; mask != 0; mask &= mask - 1) {
        uint32_t child = lowest_bit(mask);
        if (level > 1) {
            count += collect(tree, level - 1, below + child, chosen, floor, positions + count);
        }
        branch->gap[child] = eight_highest(eight_load(tree->levels[level - 1][below + child].gap));
    }
    return count;
}

static float insert_in_leaf(const stp_tree* tree, uint32_t index, const stp_chosen* point)
{
    stp_leaf* leaf = &tree->leaves[index];
    wide maximum = wide_set(-1.0f);
    for (int i = 0; i < STP_LEAF_SIZE; i += WIDE) {
        wide squared = squared_distance(wide_load(leaf->x + i), wide_load(leaf->y + i),
                                        wide_load(leaf->z + i), point);
        wide gaps = wide_load(leaf->gap + i);
        if (tree->normals != NULL && wide_less(squared, gaps) != 0) {
            uint32_t away = facing_away(&tree->normals[index], i, point);
            squared = wide_highest(gaps) > tree->side_penalty_squared
                          ? squared_side_aware(squared, away, tree->side_penalty)
                          : wide_blend(squared, wide_set(DISTANT), away);
        }
        gaps = wide_min(gaps, squared);
        wide_store(leaf->gap + i, gaps);
        maximum = wide_max(maximum, gaps);
    }
    return wide_highest(maximum);
}

static float insert_below(stp_tree* tree, uint32_t level, uint32_t index, const stp_chosen* point,
                          float floor)
{
    stp_branch* branch = &tree->levels[level][index];
    for (uint32_t mask = reached(branch, eight_load(branch->gap), spread(point)); mask != 0;
         mask &= mask - 1) {
        uint32_t child = lowest_bit(mask), below = index * STP_BRANCH_SIZE + child;
        float gap = level != 0 ? insert_below(tree, level - 1, below, point, floor)
                               : insert_in_leaf(tree, below, point);
        branch->gap[child] = gap < floor ? -1.0f : gap;
    }
    return eight_highest(eight_load(branch->gap));
}

static float insert(stp_tree* tree, const stp_chosen* point, float floor)
{
    return insert_below(tree, tree->level_count - 1, 0, point, floor);
}

static uint32_t farthest(const stp_tree* tree)
{
    uint32_t level = tree->level_count - 1, index = 0;
    float gap = eight_highest(eight_load(tree->levels[level][0].gap));
    for (;; --level) {
        uint32_t mask = eight_equal(eight_load(tree->levels[level][index].gap), eight_set(gap));
        index = index * STP_BRANCH_SIZE + lowest_bit(mask);
        if (level == 0) {
            break;
        }
    }
    uint32_t i = 0, mask = 0;
    for (; i < STP_LEAF_SIZE; i += WIDE) {
        mask = wide_equal(wide_load(tree->leaves[index].gap + i), wide_set(gap));
        if (mask != 0) {
            break;
        }
    }
    return index * STP_LEAF_SIZE + i + lowest_bit(mask);
}

// A child's box and largest gap, as stored in a branch.
typedef struct child_bounds {
    float low[3], high[3], gap;
} child_bounds;

static void bound_column(const float* values, float* low, float* high)
{
    wide minimum = wide_load(values), maximum = minimum;
    for (int i = WIDE; i < STP_LEAF_SIZE; i += WIDE) {
        minimum = wide_min(minimum, wide_load(values + i));
        maximum = wide_max(maximum, wide_load(values + i));
    }
    *low = wide_lowest(minimum);
    *high = wide_highest(maximum);
}

static child_bounds bound_leaf(const stp_leaf* leaf)
{
    child_bounds bounds;
    float lowest;
    bound_column(leaf->x, &bounds.low[0], &bounds.high[0]);
    bound_column(leaf->y, &bounds.low[1], &bounds.high[1]);
    bound_column(leaf->z, &bounds.low[2], &bounds.high[2]);
    bound_column(leaf->gap, &lowest, &bounds.gap);
    return bounds;
}

static child_bounds bound_branch(const stp_branch* branch)
{
    return (child_bounds){
        {eight_lowest(eight_load(branch->low_x)), eight_lowest(eight_load(branch->low_y)),
         eight_lowest(eight_load(branch->low_z))},
        {eight_highest(eight_load(branch->high_x)), eight_highest(eight_load(branch->high_y)),
         eight_highest(eight_load(branch->high_z))},
        eight_highest(eight_load(branch->gap)),
    };
}

static void fit_facing(stp_facing* facing, uint32_t child, const stp_leaf_normals* normals)
{
    if (normals == NULL) {
        facing->low_x[child] = facing->low_y[child] = facing->low_z[child] = 0.0f;
        facing->high_x[child] = facing->high_y[child] = facing->high_z[child] = 0.0f;
        return;
    }
    bound_column(normals->x, &facing->low_x[child], &facing->high_x[child]);
    bound_column(normals->y, &facing->low_y[child], &facing->high_y[child]);
    bound_column(normals->z, &facing->low_z[child], &facing->high_z[child]);
}

static void fit(stp_tree* tree, uint32_t level, size_t begin, size_t end)
{
    uint32_t size = level == 0 ? tree->leaf_count : tree->level_sizes[level - 1];
    for (size_t index = begin; index < end; ++index) {
        stp_branch* branch = &tree->levels[level][index];
        for (uint32_t child = 0; child < STP_BRANCH_SIZE; ++child) {
            size_t below = index * STP_BRANCH_SIZE + child;
            child_bounds bounds = {
                {DISTANT, DISTANT, DISTANT}, {-DISTANT, -DISTANT, -DISTANT}, -1.0f};
            if (below < size) {
                bounds = level == 0 ? bound_leaf(&tree->leaves[below])
                                    : bound_branch(&tree->levels[level - 1][below]);
            }
            branch->low_x[child] = bounds.low[0];
            branch->low_y[child] = bounds.low[1];
            branch->low_z[child] = bounds.low[2];
            branch->high_x[child] = bounds.high[0];
            branch->high_y[child] = bounds.high[1];
            branch->high_z[child] = bounds.high[2];
            branch->gap[child] = bounds.gap;
            if (level == 0 && tree->facing != NULL) {
                fit_facing(&tree->facing[index], child,
                           below < size ? &tree->normals[below] : NULL);
            }
        }
    }
}

const stp_tree_kernels KERNELS = {fit, insert, farthest, push, collect};
