// SPDX-License-Identifier: MIT
//
// Simplifies the triangles of a group of clusters, and measures how its look changes.
#pragma once

#include "base/math/math.h"
#include "lod/levels/collapse.h"

/// Triangles to be simplified, or what is left of them. The arrays are owned.
typedef struct stp_group_mesh {
    uint32_t vertex_count, triangle_count;
    float* positions;   ///< 3 per vertex
    uint32_t* vertices; ///< number of each vertex elsewhere; UINT32_MAX: it has moved
    uint8_t* locked;    ///< per vertex: not 0 if it stays
    uint32_t* indices;  ///< 3 per triangle
    uint32_t* tags;     ///< one per triangle
    bool keeps_tags;    ///< borders between tags are kept, as open borders are
    uint8_t* sides;     ///< one per triangle (STP_SEEN_*)
    float* colors;      ///< NULL, or red, green, blue of each corner: 9 per triangle, linear
    /// 2 per triangle: mean squared difference from the originals at its place, of colours (0 to 1
    /// a channel, as the eye sees them) and of normals (radians)
    float* spreads;
} stp_group_mesh;

/// Allocates everything but `vertices`, `positions` and `locked`, which stp_group_number makes.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Destroy in either case
STP_MUST_USE stp_result stp_group_create(stp_context* context, uint32_t triangle_count, bool colors,
                                         stp_group_mesh* group);
/// Numbers the vertices that `indices` name from 0, ascending: fills `vertices`, and makes room for
/// positions and locks.
STP_MUST_USE stp_result stp_group_number(stp_context* context, stp_group_mesh* group);
/// Simplifies the group. A corner gets the mean colour of the corners of its tag that were merged
/// there, weighted by area. The spreads of all triangles become those of the group. @param error
/// receives the error of the collapses @param spreads  receives the spreads of the group @param
/// size receives the size of a triangle: the root of twice their mean area
STP_MUST_USE stp_result stp_group_simplify(stp_context* context, const stp_collapse_desc* desc,
                                           stp_group_mesh* group, double* error, double spreads[2],
                                           double* size);
void stp_group_destroy(stp_context* context, stp_group_mesh* group);
