// SPDX-License-Identifier: MIT
// Edges of triangles, so that those that share one are found together.
#pragma once

#include "base/core/context.h"

/// The ends of the edge from a corner to the next one of its triangle, the smaller first.
static inline void stp_edge_ends(const uint32_t* indices, uint32_t corner, uint32_t ends[2])
{
    uint32_t triangle = corner / 3, k = corner % 3;
    uint32_t a = indices[corner], b = indices[3 * triangle + (k + 1) % 3];
    ends[0] = a < b ? a : b;
    ends[1] = a < b ? b : a;
}

/// Sorts the corners of all triangles by the edges that begin there; corners of one edge ascend.
/// @return 3 * triangle_count corners (stp_free); NULL if out of memory (not logged)
uint32_t* stp_sort_edges(stp_context* context, const uint32_t* indices, uint32_t triangle_count,
                         uint32_t vertex_count);

/// The end of the run of corners in `order` that have the same edge as the one at `begin`.
uint32_t stp_edge_run(const uint32_t* indices, const uint32_t* order, uint32_t begin,
                      uint32_t count);
