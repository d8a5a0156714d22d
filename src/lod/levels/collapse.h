// SPDX-License-Identifier: MIT
//
// Simplifies triangles by edge collapses (Garland, Heckbert 1997, "Surface Simplification Using
// Quadric Error Metrics"). Each vertex has a quadric: the sum of squared distances to the planes of
// the triangles that it stands for, weighted by their areas. The edge whose collapse costs least is
// collapsed first, into the place where the sum of both quadrics is smallest.
//
// Differences from the paper:
//   * Topology may change: surfaces may touch in a vertex or an edge, so that parts with cracks and
//     open borders, of which CAD data is full, are simplified as far as closed ones.
//   * Borders between materials are kept like open ones.
//   * Chosen vertices are locked: their places stay, so that meshes that share them still meet.
//   * No collapse turns a triangle by more than a limit.
#pragma once

#include "base/core/context.h"

/// The most triangles around the vertex that a collapse leaves: it bounds the work of one collapse.
enum { STP_COLLAPSE_FAN = 192 };

/// Triangles of distinct corners. The caller owns all arrays.
typedef struct stp_collapse_mesh {
    uint32_t vertex_count, triangle_count; ///< the latter falls
    float* positions;  ///< 3 per vertex, finite; those of vertices that are left may move
    uint32_t* indices; ///< 3 per triangle; those left are moved to the front, in their order
    uint32_t* tags;    ///< NULL, or one number per triangle, which is moved along
    /// NULL, or the material of each triangle, not moved along: edges between materials are borders
    const uint32_t* materials;
    const uint8_t* locked; ///< NULL, or one per vertex: not 0 if it must stay and keep its place
    uint32_t* merged;      ///< NULL, or one per vertex: receives the vertex that stands for it
} stp_collapse_mesh;

/// When to stop, and what to forbid.
typedef struct stp_collapse_desc {
    /// Stops when at most so many triangles, or so many used vertices, are left; 0: no such limit
    uint32_t triangle_target, vertex_target;
    /// Stops before a collapse with a larger error: the root of the mean squared distance to the
    /// planes. In units of the positions; HUGE_VAL: no limit
    double error_limit;
    /// Weight of planes through open edges and edges between materials, perpendicular to their
    /// triangles, which keep borders in place; relative to the squared length of the edge, or to
    /// twice the triangle's area if that is larger. 0: borders are free
    double border_weight;
    /// Least cosine of the angle by which a collapse may turn a triangle, -1 to 1
    double least_cosine;
} stp_collapse_desc;

/// Simplifies a mesh. Deterministic; may run inside jobs.
/// @param error receives the largest error of a collapse; 0 if there was none
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged; the mesh is then as it was)
STP_MUST_USE stp_result stp_collapse(stp_context* context, stp_collapse_mesh* mesh,
                                     const stp_collapse_desc* desc, double* error);
