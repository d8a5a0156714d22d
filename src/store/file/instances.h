// SPDX-License-Identifier: MIT
//
// Occurrences of a node, mesh or point set in the scene. Objects keep their nodes, but partitioning
// may have moved their content to other nodes. So an occurrence is identified by its content and
// transform, not by a path. Two transforms are equal if they differ by less than a millionth of the
// content's size, because rounding differs between paths.
#pragma once

#include "store/file/store.h"

enum { STP_INSTANCE_DEPTH = 1000 }; ///< graph levels that are searched

/// A node, mesh or point set with a transform.
typedef struct stp_instance {
    bool is_part;
    stp_store_part part;
    uint32_t node;
    stp_affine transform; ///< to scene space
    stp_boxd bounds;      ///< in its own space
    stp_vec3d center;     ///< center of the bounds, in scene space
} stp_instance;

stp_instance stp_instance_of_node(const stp_store* store, uint32_t node,
                                  const stp_affine* transform);
stp_instance stp_instance_of_part(const stp_store* store, stp_store_part part,
                                  const stp_affine* transform);

/// Whether two transforms map a box to the same position.
bool stp_instance_is_same(const stp_boxd* bounds, const stp_affine* a, const stp_affine* b);

/// Whether a point lies in the box around a transformed box, within rounding.
bool stp_instance_may_hold(const stp_boxd* bounds, const stp_affine* transform, stp_vec3d point);

/// A bounded walk through the graph.
typedef struct stp_instance_search {
    const stp_store_directory* directory;
    const uint8_t* reaches; ///< optional: for each node, whether it is worth descending
    uint64_t visits_left;
    bool gave_up; ///< it reached the limit of visited nodes or STP_INSTANCE_DEPTH
} stp_instance_search;

/// Whether a node with a transform is the occurrence, or contains it.
bool stp_instance_holds(stp_instance_search* search, uint32_t node, const stp_affine* transform,
                        const stp_instance* instance);
