// SPDX-License-Identifier: MIT
//
// Original triangles as clusters: up to 128 triangles and 256 vertices that lie near each other, quantised on
// the mesh's power-of-two grid with an origin per cluster, so that vertices shared by neighbouring clusters (and
// by pieces of one mesh that was cut: same step) round to the same place and nothing cracks. docs/format.md is
// the authority on the bytes.
#pragma once

#include "store/store.h"

enum { STP_CLUSTER_TRIANGLES = 128, STP_CLUSTER_VERTICES = 256 };

/// A mesh coded: what the writer stores as one block. `bytes` may lie in a mapped file.
typedef struct stp_coded_mesh {
    const void* bytes;
    size_t size;
    uint32_t cluster_count, triangle_count, vertex_count; ///< vertices: sum over clusters
    stp_box bounds;                                       ///< of the quantised positions
} stp_coded_mesh;

/// Codes a mesh on the grid of `step` (base/position_grid.h; pieces of one mesh are given the step of the
/// whole; float arrays as in stp_store_mesh; normals octahedral 16 bit) into memory of the context
/// (stp_free of `bytes`). Deterministic; may run inside jobs.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT
STP_MUST_USE stp_result stp_clusters_encode(stp_context* context, const stp_store_mesh* mesh,
                                            double step, stp_coded_mesh* coded);
