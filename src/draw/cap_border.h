// SPDX-License-Identifier: MIT
//
// Whether a surface is closed except for cracks. CAD programs triangulate the faces of a body
// independently, so a common curve has different vertices on each side and its edges do not match.
// The border of such a crack encloses almost no area. The border of a sheet or an open pipe
// encloses the missing surface.
#pragma once

#include "base/core/context.h"
#include "base/math/math.h"

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

/// Hash of a position; -0 equals 0.
uint64_t stp_cap_hash_corner(const float p[3]);
