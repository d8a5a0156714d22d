// SPDX-License-Identifier: MIT
//
// Points in the order of a space-filling curve, under a tree of boxes. Each leaf holds 32 points
// and, for each, the squared distance to the nearest point chosen so far; each branch holds, for
// its 8 children, the boxes and the largest of those distances. A newly chosen point can change a
// child only where
//
//     squared distance to the child's box  <  the child's largest squared distance
//
// so one comparison of eight lanes prunes eight children. This holds for every dissimilarity that
// is never smaller than the Euclidean distance.
//
//   levels[2]                 [........]
//   levels[1]        [........][........] ...           8 children per branch, all levels implicit
//   levels[0]   [........][........][........] ...
//   leaves      | 32 points | 32 points | ...           structure of arrays
//
// All squared distances are evaluated as (dx * dx + dy * dy) + dz * dz in single precision without
// fused multiply-add, and box distances in the same order of operations, so that rounding (which is
// monotone) can never make a box look farther than a point in it, and all vector widths agree to
// the bit.
#pragma once

#include "base/core/jobs.h"

#include <stipple/types.h>

enum {
    STP_LEAF_SIZE = 32,
    STP_BRANCH_SIZE = 8,
    STP_PENDING_SIZE = 15,
    STP_TREE_LEVELS = 11, ///< enough for 2^32 points
};

typedef struct stp_leaf {
    float x[STP_LEAF_SIZE], y[STP_LEAF_SIZE], z[STP_LEAF_SIZE];
    /// Squared distance to the nearest chosen point; -1 in lanes past the end
    float gap[STP_LEAF_SIZE];
} stp_leaf;

typedef struct stp_leaf_normals {
    float x[STP_LEAF_SIZE], y[STP_LEAF_SIZE], z[STP_LEAF_SIZE];
} stp_leaf_normals;

/// Boxes and largest gaps of eight children. A child that does not exist has an inverted box and
/// gap -1.
typedef struct stp_branch {
    float low_x[STP_BRANCH_SIZE], low_y[STP_BRANCH_SIZE], low_z[STP_BRANCH_SIZE];
    float high_x[STP_BRANCH_SIZE], high_y[STP_BRANCH_SIZE], high_z[STP_BRANCH_SIZE];
    float gap[STP_BRANCH_SIZE];
    float spare[STP_BRANCH_SIZE];
} stp_branch;

/// Boxes around the normals of eight leaves. They tell whether a whole leaf faces the same way as a
/// point, or away.
typedef struct stp_facing {
    float low_x[STP_BRANCH_SIZE], low_y[STP_BRANCH_SIZE], low_z[STP_BRANCH_SIZE];
    float high_x[STP_BRANCH_SIZE], high_y[STP_BRANCH_SIZE], high_z[STP_BRANCH_SIZE];
} stp_facing;

/// Chosen points that a leaf has not applied yet: one cache line. Until then, the leaf's gaps and
/// the maxima above it are upper bounds.
typedef struct stp_pending {
    uint16_t count;
    uint16_t mixed; ///< bit i: some or all of the leaf's points may face away from chosen[i]
    uint32_t chosen[STP_PENDING_SIZE];
} stp_pending;

typedef struct stp_chosen {
    float x, y, z;
    float normal_x, normal_y, normal_z; ///< zero if there are no normals
} stp_chosen;

typedef struct stp_tree {
    uint32_t point_count, leaf_count, level_count;
    uint32_t level_sizes[STP_TREE_LEVELS]; ///< branches per level; the last level has one
    stp_leaf* leaves;
    stp_leaf_normals* normals; ///< NULL: Euclidean
    stp_facing* facing;        ///< one per branch of level 0; NULL: not kept
    stp_pending* pending;      ///< one per leaf; NULL: changes are applied immediately
    stp_branch* levels[STP_TREE_LEVELS];
    float side_penalty;         ///< added to the distance if normals face apart (side-aware metric)
    float side_penalty_squared; ///< its square is a lower bound for points that face apart
} stp_tree;

/// Kernels, in variants per CPU with identical bits.
typedef struct stp_tree_kernels {
    /// Computes the boxes (and normal boxes) of the branches [begin, end) of a level from the level
    /// below, and the maxima of gaps.
    void (*fit)(stp_tree* tree, uint32_t level, size_t begin, size_t end);
    /// Applies one chosen point to the whole tree. Gaps below `floor` are ignored: leaves with only
    /// such gaps count as empty. @return the largest remaining gap, -1 if none
    float (*insert)(stp_tree* tree, const stp_chosen* point, float floor);
    /// The lowest position that has the tree's largest gap.
    uint32_t (*farthest)(const stp_tree* tree);
    /// Records `count` chosen points in the leaves below one branch. `list` holds their indices in
    /// `chosen`. `scratch` has room for stp_tree_push_scratch(count) indices.
    void (*push)(stp_tree* tree, uint32_t level, uint32_t branch, const stp_chosen* chosen,
                 const uint32_t* list, uint32_t count, uint32_t* scratch);
    /// Updates all leaves below one branch that may hold a gap of at least `floor` (above 0), and
    /// lists the positions of such gaps, ascending. @return their number
    uint32_t (*collect)(stp_tree* tree, uint32_t level, uint32_t branch, const stp_chosen* chosen,
                        float floor, uint32_t* positions);
} stp_tree_kernels;

extern const stp_tree_kernels stp_tree_kernels_portable;
extern const stp_tree_kernels stp_tree_kernels_vector;
extern const stp_tree_kernels stp_tree_kernels_wide;

/// The widest kernels that this CPU runs.
const stp_tree_kernels* stp_tree_kernels_select(void);

/// Allocates a tree for `point_count` points, 1 or more. The content is uninitialised.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged; `tree` is then empty)
STP_MUST_USE stp_result stp_tree_create(stp_context* context, stp_tree* tree, uint32_t point_count,
                                        bool normals, bool lazy);
void stp_tree_destroy(stp_context* context, stp_tree* tree);

/// Changes the number of points in the tree, within the allocated capacity.
void stp_tree_resize(stp_tree* tree, uint32_t point_count);

/// Fills the lanes past the last point, then computes all boxes and maxima.
void stp_tree_fit(stp_tree* tree, const stp_tree_kernels* kernels, const stp_team* team);

/// The largest gap, or an upper bound if changes are pending.
float stp_tree_gap(const stp_tree* tree);

/// Scratch size, in indices, for a push of `count` points.
size_t stp_tree_push_scratch(const stp_tree* tree, uint32_t count);
