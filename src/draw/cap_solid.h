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

/// Calls `take` for each triangle of a mesh in boxes that `wants` accepts.
typedef struct stp_cap_visitor {
    bool (*wants)(void* user, const stp_box* box); ///< NULL: all
    stp_result (*take)(void* user, const float* const corners[3]);
    void* user;
} stp_cap_visitor;

STP_MUST_USE stp_result stp_cap_visit(stp_store* store, uint32_t mesh,
                                      const stp_cap_visitor* visitor);
