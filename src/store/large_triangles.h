// SPDX-License-Identifier: MIT
//
// The large triangles of a mesh by falling size, so that a view finds those worth drawing beside splats by a search
// (Dachsbacher et al. 2003, 3.8). The list is made of the clusters when it is first asked for; it is not in the file.
#pragma once

#include "store/store.h"

/// A view that wants splats of a triangle's level (base/triangle_level.h) or smaller ones there draws the triangle.
typedef struct stp_large_triangles {
    uint32_t count;
    const uint32_t* triangles; ///< of the mesh
    /// Falling by bands, two an octave. Triangles of a band lie in the mesh's order.
    const float* levels;
} stp_large_triangles;

/// Lists the triangles of a mesh of clusters whose level is `least` or more, and perhaps some that are smaller. The arrays are
/// the store's and stay until it is closed. One thread at a time.
/// @return STP_OK; STP_ERROR_FORMAT, STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (as
///         stp_store_get_clusters; logged)
STP_MUST_USE stp_result stp_store_get_large_triangles(stp_store* store, uint32_t mesh, float least,
                                                      stp_large_triangles* list);

/// How many of the first triangles may have a level of `level` or more.
uint32_t stp_large_triangles_find(const stp_large_triangles* list, float level);
