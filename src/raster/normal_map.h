// SPDX-License-Identifier: MIT
//
// Normal maps, as glTF defines them: red along increasing u, green along decreasing v, since v
// points down and green means up, blue along the surface's normal; 0 to 1 stands for -1 to 1.
// Tangents are those of each triangle. src/draw/shaders/lib_normal_map.glsl does the same.
#pragma once

#include "base/math/math.h"

#include <stdbool.h>

/// Directions on a triangle, of any length, in the space of its corners.
typedef struct stp_tangents {
    stp_vec3 right; ///< in which u increases
    stp_vec3 up;    ///< in which v decreases; may be mirrored
} stp_tangents;

/// @param edges from corner 0 to corners 1 and 2
/// @param uv change of the texture coordinates along each edge
/// @return false: the coordinates do not span the triangle, or are not finite: no tangents
bool stp_tangents_find(const stp_vec3 edges[2], const float uv[2][2], stp_tangents* tangents);

/// The normal that a map gives.
/// @param normal unit length, in the space of the tangents, on either side of the triangle
/// @param texel of the map, mean of some texels; 3 values
/// @param scale factor of its first two
/// @param eye unit length, towards the eye. If the surface faces it, so does the result, and
/// likewise if it faces away: light takes a normal that faces away for that of the other side.
/// @return unit length; `normal` itself if the texel or the tangents give no direction
stp_vec3 stp_normal_map_apply(const stp_tangents* tangents, stp_vec3 normal, const float texel[3],
                              float scale, stp_vec3 eye);
