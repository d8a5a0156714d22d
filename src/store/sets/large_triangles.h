// SPDX-License-Identifier: MIT
//
// The large triangles of a mesh, sorted by decreasing size. A view searches the list for triangles
// that it draws beside splats (Dachsbacher et al. 2003, 3.8). The list is built from the clusters
// on first use; the file does not store it.
#pragma once

#include "store/file/store.h"

/// A view draws a triangle if its splats there have the triangle's level (base/splats/triangle_level.h) or
/// a smaller one.
typedef struct stp_large_triangles {
    uint32_t count;
    const uint32_t* triangles; ///< index in the mesh
    /// Decreasing by bands, two per octave. Within a band, triangles are in mesh order.
    const float* levels;
} stp_large_triangles;

/// Lists the triangles of a coded mesh whose level is at least `minimum`, and perhaps some smaller
/// ones. The store owns the arrays until it is closed. One thread at a time. @return STP_OK;
/// STP_ERROR_FORMAT, STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_ARGUMENT (as
/// stp_store_get_clusters; logged)
STP_MUST_USE stp_result stp_store_get_large_triangles(stp_store* store, uint32_t mesh,
                                                      float minimum, stp_large_triangles* list);

/// Length of the prefix that contains all triangles with a level of at least `level`.
uint32_t stp_large_triangles_find(const stp_large_triangles* list, float level);
