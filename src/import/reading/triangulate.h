// SPDX-License-Identifier: MIT
// Splits polygons into triangles.
#pragma once

#include "base/core/context.h"

/// Splits a polygon of `count` (at least 3) corners into count - 2 triangles. `corners` index
/// `positions` (3 floats each); `triangles` receives 3 indices per triangle, with the polygon's
/// winding. A convex polygon becomes a fan, in linear time. A concave one is clipped ear by ear (Meisters
/// 1975); one that is too large and jagged for that (the work per corner is bounded) ends as a fan.
/// Any thread. @return false if memory runs out (not logged)
STP_MUST_USE bool stp_triangulate(stp_context* context, const float* positions,
                                  const uint32_t* corners, uint32_t count, uint32_t* triangles);
