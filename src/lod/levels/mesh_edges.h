// SPDX-License-Identifier: MIT
// Edges of triangles, so that those that share one are found together.
#pragma once

#include "base/core/context.h"

/// The edges of a mesh, ascending by their smaller end, then by the other one.
typedef struct stp_mesh_edges {
    uint32_t count;
    uint32_t* ends;    ///< of each edge in `corners`
    uint32_t* corners; ///< at which an edge begins: edge by edge, ascending within each
} stp_mesh_edges;

/// The ends of the edge from a corner to the next one of its triangle, the smaller first.
static inline void stp_edge_ends(const uint32_t* indices, uint32_t corner, uint32_t ends[2])
{
    uint32_t a = indices[corner], b = indices[corner % 3 == 2 ? corner - 2 : corner + 1];
    ends[0] = a < b ? a : b;
    ends[1] = a < b ? b : a;
}

/// Finds the edges. `indices`: below `vertex_count`. @return false if out of memory (not logged).
/// Destroy in either case
STP_MUST_USE bool stp_mesh_edges_make(stp_context* context, const uint32_t* indices,
                                      uint32_t triangle_count, uint32_t vertex_count,
                                      stp_mesh_edges* edges);
void stp_mesh_edges_destroy(stp_context* context, stp_mesh_edges* edges);
