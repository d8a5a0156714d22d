// SPDX-License-Identifier: MIT
//
// Things of the graph at places of the scene. Objects keep their nodes, but partition may have spread their content over
// others' nodes: a thing is then found by what it is and where it stands, not by a path. Places are the same where they
// differ by less than a millionth of the thing's size: products of transforms round differently along different paths.
#pragma once

#include "store/store.h"

enum { STP_INSTANCE_DEPTH = 1000 }; ///< levels of a graph that are looked at

/// A node, or a mesh or point set, at a place.
typedef struct stp_instance {
    bool is_part;
    stp_store_part part;
    uint32_t node;
    stp_affine transform; ///< to scene space
    stp_boxd bounds;      ///< in its own space
    stp_vec3d center;     ///< of them, scene space
} stp_instance;

stp_instance stp_instance_of_node(const stp_store* store, uint32_t node,
                                  const stp_affine* transform);
stp_instance stp_instance_of_part(const stp_store* store, stp_store_part part,
                                  const stp_affine* transform);

/// Whether two transforms put a box to the same place.
bool stp_instance_is_same(const stp_boxd* bounds, const stp_affine* a, const stp_affine* b);

/// Whether a point lies in the box that holds a transformed box, or so near as rounding may bring it.
bool stp_instance_may_hold(const stp_boxd* bounds, const stp_affine* transform, stp_vec3d point);

/// A walk through the graph that must end.
typedef struct stp_instance_search {
    const stp_store_directory* directory;
    const uint8_t* reaches; ///< NULL, or of each node whether it is worth looking into
    uint64_t visits_left;
    bool gave_up; ///< it had too many nodes to look at
} stp_instance_search;

/// Whether a node at a place is the thing, or has it below it.
bool stp_instance_holds(stp_instance_search* search, uint32_t node, const stp_affine* transform,
                        const stp_instance* thing);
