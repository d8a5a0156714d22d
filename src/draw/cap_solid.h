// SPDX-License-Identifier: MIT
// Which meshes are closed, and their orientation: determined when a section first cuts one, and
// cached.
#pragma once

#include "store/file/store.h"

typedef struct stp_cap_solids stp_cap_solids;

STP_MUST_USE stp_result stp_cap_solids_create(stp_context* context, stp_store* store,
                                              stp_cap_solids** solids);
void stp_cap_solids_destroy(stp_cap_solids* solids); ///< NULL is allowed

/// @param side receives 1 if the mesh, or all its pieces together, is closed and its triangles face
/// outwards, -1 if they face inwards, 0 if it is open
STP_MUST_USE stp_result stp_cap_solids_side(stp_cap_solids* solids, uint32_t mesh, int* side);

typedef struct stp_cap_visitor {
    /// Whether to visit a cluster with these bounds; NULL: all. Not called for meshes of columns.
    bool (*wants)(void* user, const stp_box* box);
    stp_result (*take)(void* user, const float* const corners[3]);
    void* user;
} stp_cap_visitor;

/// Calls `take` for each triangle of a mesh, but not for clusters that `wants` rejects. Stops at
/// the first failure.
STP_MUST_USE stp_result stp_cap_visit(stp_store* store, uint32_t mesh,
                                      const stp_cap_visitor* visitor);
