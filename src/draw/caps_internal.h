// SPDX-License-Identifier: MIT
// Steps of making the caps of cut solids: outline, border, and the solid that is filled.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"
#include "store/file/store.h"

// Outlines of a plane's cut, as unordered segments.

/// A segment of an outline. Seen from the side that is cut away, the solid is on its left.
typedef struct stp_cap_segment {
    float from[3], to[3]; ///< scene space, relative to the origin of the outlines
} stp_cap_segment;

typedef struct stp_cap_outline {
    stp_cap_segment* segments;
    size_t count, capacity;
} stp_cap_outline;

/// Ignores segments beyond four million. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_outline_add(stp_context* context, stp_cap_outline* outline,
                                            const float from[3], const float to[3]);

/// Connects loose ends, which arise where a plane cuts through a crack, to nearby ones, so that all
/// outlines are closed.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_outline_close(stp_context* context, stp_cap_outline* outline);

// Whether a surface is closed except for cracks. CAD programs triangulate the faces of a body
// independently, so a common curve has different vertices on each side and its edges do not match.
// The border of such a crack encloses almost no area. The border of a sheet or an open pipe
// encloses the missing surface.

typedef struct stp_cap_border stp_cap_border;

/// `triangles`: expected number, for the size of tables.
STP_MUST_USE stp_result stp_cap_border_create(stp_context* context, uint64_t triangles,
                                              stp_cap_border** border);
void stp_cap_border_destroy(stp_cap_border* border); ///< NULL is allowed

/// Adds a triangle. Add all triangles twice, in any order, and call stp_cap_border_turn in between.
/// Memory grows with the border; above a limit the surface counts as open.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_border_add(stp_cap_border* border, const float* const corners[3]);
void stp_cap_border_turn(stp_cap_border* border);

/// Call after the second pass.
/// @param side receives 1 (closed, faces outwards), -1 (closed, faces inwards) or 0 (open).
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_border_side(stp_cap_border* border, int* side);

// Which meshes are closed, and their orientation: determined when a section first cuts one, and
// cached.

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
