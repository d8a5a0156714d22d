// SPDX-License-Identifier: MIT
//
// Whether a surface is closed but for cracks. Where CAD programs triangulate two faces of one body apart, their common
// curve has other corners on each side: no edge is used both ways, but the faces lie close together all along. Such a
// border encloses next to no area, while that of a sheet, or of a pipe without ends, encloses what is missing.
#pragma once

#include "base/context.h"
#include "base/math.h"

typedef struct stp_cap_border stp_cap_border;

/// `triangles`: how many will be given, for the size of tables.
STP_MUST_USE stp_result stp_cap_border_create(stp_context* context, uint64_t triangles,
                                              stp_cap_border** border);
void stp_cap_border_destroy(stp_cap_border* border); ///< NULL is fine

/// Gives one triangle. All are given twice, in any order: stp_cap_border_turn is called between. Memory grows with the
/// border, up to a limit from which on the surface counts as open. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_border_add(stp_cap_border* border, const float* const corners[3]);
void stp_cap_border_turn(stp_cap_border* border);

/// After the second time. @param side  receives 1 where the surface is closed but for cracks and faces outwards, -1 where it
/// faces inwards, 0 where it is open. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_cap_border_side(stp_cap_border* border, int* side);

/// A number of a corner's place, the same wherever its coordinates are.
uint64_t stp_cap_hash_corner(const float p[3]);
