// SPDX-License-Identifier: MIT
// Steps of stp_scene_partition.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"
#include "scene/scene.h"

// How the graph uses meshes and point sets.

enum { STP_USED_RESTING = 1, STP_USED_MOVING = 2 };

/// How the nodes use each mesh and each point set: arrays of one byte each (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged, nothing to free)
STP_MUST_USE stp_result stp_find_uses(const stp_scene* scene, const stp_node* nodes,
                                      size_t node_count, const stp_part* node_parts,
                                      uint8_t** mesh_uses, uint8_t** point_uses);

/// Frees the arrays of an unused mesh or point set; it keeps its index.
void stp_scene_release(stp_scene* scene, stp_part part);

/// Removes unused meshes and point sets; the others move up. Parts of objects that referred to them
/// get index STP_NONE. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_drop_unused(stp_scene* scene);

// Finds children that are as large as their parent, and so carry no spatial information.
//   storey ─┬─ walls    (as wide as the storey)          storey ─┬─ a wall, a lamp and a pipe
//           ├─ lamps    (as wide)                  ->            ├─ a wall and two lamps
//           └─ pipes    (as wide)                                └─ ...
// Build results are cached by content, so the result for a node must depend only on its content,
// not on other users of its children: otherwise a change elsewhere would change it, too. It depends
// on the rest of the scene only if dissolving would duplicate more shared items than the scene has.

enum { STP_DISSOLVED = 1, STP_DISSOLVED_IN_ROOT = 2 };

/// Finds the edges whose child is dissolved into the parent: one of several items in it, as large
/// as the parent, not moving, and with at most a few times as many items as the rest (otherwise it
/// is nearly the parent itself). Also the edges between the root and its content that only rotate
/// or scale a whole input; otherwise the whole scene would be approximated twice. `wide`: one byte
/// per edge (stp_free).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_find_dissolved(const stp_scene* scene, uint8_t** wide);

// A hierarchy of boxes: neighbours share a group, and the size of groups is limited.

/// Has either children or members: the boxes order[first] to order[first + count - 1].
typedef struct stp_group {
    uint32_t first, count;             ///< all boxes below it
    uint32_t first_child, child_count; ///< child_count 0: has `count` members
    uint32_t depth;                    ///< number of splits above it
} stp_group;

/// Group 0 contains all; children have higher indices than parents. Initialise to zero; reusable.
typedef struct stp_grouping {
    uint32_t* order;
    stp_group* groups;
    size_t group_count;
    size_t order_capacity, group_capacity;
} stp_grouping;

enum { STP_GROUP_LIMIT = 256 };

/// Groups `count` boxes (at least 1), with at most `maximum` (2 to STP_GROUP_LIMIT) members or
/// children each. Boxes may coincide, have no volume, or have any size. Time O(count log count).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_group_boxes(stp_context* context, const stp_boxd* boxes, uint32_t count,
                                        uint32_t maximum, stp_grouping* grouping);
void stp_grouping_destroy(stp_context* context, stp_grouping* grouping);

struct stp_strays; // scene/strays.h

// Splits large meshes and point sets by planes into pieces of bounded size.

/// Splits a mesh of more than `maximum` triangles into as few pieces as possible, of about equal
/// size, and appends them to the scene. Each triangle goes whole to the piece that contains its
/// centroid. Pieces keep name, material, attributes and grid step; have bounds, area and content;
/// and lie in the spill if the mesh does or memory is short. The mesh itself stays.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (logged; no piece was added)
STP_MUST_USE stp_result stp_split_mesh(stp_scene* scene, uint32_t mesh, uint32_t maximum,
                                       uint32_t* first_piece, uint32_t* piece_count);

/// Splits a point set likewise. Its strays (scene/strays.h) become pieces of their own, after the
/// others; a set with strays may have at most `maximum` points.
STP_MUST_USE stp_result stp_split_points(stp_scene* scene, uint32_t set, uint32_t maximum,
                                         const struct stp_strays* strays, uint32_t* first_piece,
                                         uint32_t* piece_count);

// Divides places by planes into runs of about equal length.

/// Position of a triangle or a point.
typedef struct stp_place {
    float at[3];
    uint32_t index;
} stp_place;

/// Reorders `places` (with distinct indices below `index_end`) so that run i of `pieces`, from
/// ends[i - 1] to ends[i] - 1, is a region bounded by planes; within a run, indices ascend. No run
/// is longer than ceil(count / pieces). Uses all threads; the result does not depend on their
/// number.
/// `in_spill`: the places lie in a spill, of which little is to be resident.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_split_ranges(stp_context* context, stp_place* places, uint32_t count,
                                         uint32_t index_end, uint32_t pieces, bool in_spill,
                                         uint32_t* ends);
