// SPDX-License-Identifier: MIT
// Unpacks many cluster values at a time.
#pragma once

#include "store/clusters/clusters.h"

enum { CLUSTERS_UNPACK_WIDTH = 16 }; ///< largest width that it handles

/// Unpacks the positions of the first vertices (x, y, z runs of `count` values), bit-identical to
/// the scalar code. Needs AVX2. @return the number of vertices done: all but the last few, or 0 if
/// the layout does not allow it
uint32_t stp_clusters_unpack_avx2(const stp_cluster_run runs[3], uint32_t count, float step,
                                  float* positions);
