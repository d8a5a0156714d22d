// SPDX-License-Identifier: MIT
// A balanced kd-tree with eight points per leaf: the order of its leaves is also an order of the
// points in space.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"
#include "lod/psp/room.h"

#include <assert.h>

// Splits points in space: the step that kd-trees and the pieces of a large merge share.

/// A point and its number. The number also breaks ties, so each order along an axis is total.
typedef struct stp_kd_point {
    float at[3];
    uint32_t index;
} stp_kd_point;

/// Axis of the largest extent; of many points, estimated from a sample. `count` is at least 1.
int stp_kd_widest(const stp_kd_point* points, size_t count);

/// Quickselect along an axis: moves smaller points before `place`, and larger ones after it.
/// `place` is below `count`. Expected linear time for any input. The result depends on the input
/// alone.
/// @param room storage of the points, whose pages are released during the split; NULL: in memory
void stp_kd_select(stp_kd_point* points, size_t count, size_t place, int axis,
                   const stp_psp_room* room);

enum { STP_KD_LEAF = 8, STP_KD_DEPTH = 40, STP_NEIGHBOURS_MAX = 32 };

/// Points of a leaf, one array per coordinate. The last leaf is padded with points at infinity.
typedef struct stp_kd_leaf {
    float at[3][STP_KD_LEAF];
    uint32_t index[STP_KD_LEAF]; ///< input index of each point
} stp_kd_leaf;

typedef struct stp_kd_node {
    float split;   ///< coordinate: points before the middle are at most this, others at least this
    uint32_t axis; ///< 0 to 2
} stp_kd_node;

/// A range of leaves [b, e) is split at its middle leaf (b + e) / 2, which is also the index of its
/// node.
typedef struct stp_kd_tree {
    stp_kd_leaf* leaves;
    stp_kd_node* nodes; ///< one per leaf; the first is unused
    uint32_t count, leaf_count;
    const stp_psp_room* room; ///< storage of both arrays; NULL: in memory
} stp_kd_tree;

/// Reads coordinates times `scale`. NaN counts as 0; magnitudes are clamped to 1e18 before scaling.
/// Uses all threads; the tree does not depend on their number.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_kd_tree_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_kd_tree_make(stp_context* context, const float* positions,
                                         uint32_t count, float scale, stp_kd_tree* tree);
/// The same in a storage room, which must outlive the tree. @return also STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_kd_tree_make_in(stp_context* context, const stp_psp_room* room,
                                            const float* positions, uint32_t count, float scale,
                                            stp_kd_tree* tree);
void stp_kd_tree_destroy(stp_context* context, stp_kd_tree* tree);

/// Sanitises a coordinate as the tree does.
static inline float stp_kd_clean(float x, float scale)
{
    return scale * (x >= -1e18f && x <= 1e18f ? x : x > 0.0f ? 1e18f : x < 0.0f ? -1e18f : 0.0f);
}

/// The point at a place: item place % 8 of leaf place / 8.
static inline stp_vec3 stp_kd_at(const stp_kd_tree* tree, uint32_t place)
{
    assert(place < tree->count);
    const stp_kd_leaf* leaf = &tree->leaves[place / STP_KD_LEAF];
    uint32_t i = place % STP_KD_LEAF;
    return (stp_vec3){leaf->at[0][i], leaf->at[1][i], leaf->at[2][i]};
}

static inline uint32_t stp_kd_index(const stp_kd_tree* tree, uint32_t place)
{
    assert(place < tree->count && "not the padding of the last leaf");
    return tree->leaves[place / STP_KD_LEAF].index[place % STP_KD_LEAF];
}

/// The box of all points; empty without points.
stp_box stp_kd_box(const stp_kd_tree* tree);

/// Search path to a leaf; consecutive searches reuse it.
typedef struct stp_kd_path {
    uint32_t leaf;  ///< UINT32_MAX: none yet
    uint32_t depth; ///< number of steps from the root
    struct {
        uint32_t begin, end; ///< leaves on the other side
        stp_kd_node node;
    } steps[STP_KD_DEPTH];
} stp_kd_path;

/// Finds the k points nearest to the one at a place, not including itself. Which of equally distant
/// points are found depends on the tree alone.
/// @param path one per thread, initialised with leaf UINT32_MAX. Searches in order of places are
///         faster
/// @param k 1 to STP_NEIGHBOURS_MAX
/// @param places receives them, nearest first
/// @return number found: k, or all other points if there are fewer
uint32_t stp_kd_nearest(const stp_kd_tree* tree, stp_kd_path* path, uint32_t place, uint32_t k,
                        uint32_t* places);

// The k nearest neighbours of each point of a set.

/// Converts the result of stp_kd_nearest to the format of stp_find_nearest_points, in k entries.
void stp_list_neighbours(const stp_kd_tree* tree, uint32_t place, const uint32_t* places,
                         uint32_t count, uint32_t k, uint32_t* neighbours);

/// Lists for each point its nearest other points, nearest first, ties by index. If several points
/// tie for the last entry, any of them may be listed; which one depends on the points alone. Runs
/// on all threads; results do not depend on their number.
/// @param positions 3 floats per point, read as stp_kd_tree_make does
/// @param k 1 to STP_NEIGHBOURS_MAX
/// @param neighbours receives k entries per point; UINT32_MAX for missing ones
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_nearest_points(stp_context* context, const float* positions,
                                                uint32_t count, uint32_t k, uint32_t* neighbours);
