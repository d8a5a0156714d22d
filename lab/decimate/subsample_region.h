// SPDX-License-Identifier: MIT
// The region around a point that one splat can represent.
#pragma once

#include "lab/decimate/subsample_grow.h"

/// Memory of one worker, for regions of one field.
typedef struct stp_subsample_scratch {
    stp_context* context;
    uint32_t* visited; ///< per point: number of the last region that reached it
    uint32_t region;
    uint64_t* heap; ///< points to visit: distance, then index
    size_t heap_capacity;
    uint32_t heap_count;
    uint32_t* members[2]; ///< points of the best region so far, and of the one that is tried
    size_t capacity[2];
} stp_subsample_scratch;

/// Grows a circle from a point over the neighbour graph until the next point does not fit in the
/// slab. Then fits a quadric to its points, and grows an ellipse with the quadric's tangent plane
/// and curvatures. Keeps the larger region.
/// @param members receives the covered points, in scratch memory valid until the next call
/// @return the number of points, the seed first; 0: out of memory (not logged)
uint32_t stp_subsample_find_region(const stp_subsample_field* field, stp_subsample_scratch* scratch,
                                   uint32_t seed, double tolerance, uint32_t maximum,
                                   stp_subsample_candidate* shape, const uint32_t** members);
