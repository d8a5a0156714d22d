// SPDX-License-Identifier: MIT
// Values of clusters unpacked many at a time.
#pragma once

#include "store/clusters.h"

enum { CLUSTERS_UNPACK_WIDTH = 16 }; ///< wider values are left alone

/// Positions of the first vertices, to the bit as one by one (x, y, z of each; runs of so many values). Needs AVX2.
/// @return how many vertices: all but a few where it can be done so, or none
uint32_t clusters_unpack_avx2(const stp_cluster_run runs[3], uint32_t count, float step,
                              float* positions);
