// SPDX-License-Identifier: MIT
//
// How evenly the prefixes of an order are spaced, and how well they cover (Brandt 3.3).
#pragma once

#include "base/core/context.h"

typedef struct stp_distribution {
    uint32_t count;
    double spacing_min, spacing_median; ///< distance to the nearest other point of the prefix
    double coverage_p50, coverage_p99,
        coverage_max;            ///< distance of each point of the set to the prefix
    double even_spacing;         ///< the largest possible: as many points on a hexagonal lattice
    double relative_spacing_min; ///< spacing_min over even_spacing
    double uncovered_fraction;   ///< share farther from the prefix than its median spacing
} stp_distribution;

/// Statistics of the first `count` of `ordered` against `points` (3 floats each). `spacings` (may
/// be NULL) receives the `count` nearest-neighbour distances.
STP_MUST_USE stp_result stp_distribution_measure(stp_context* context, const float* ordered,
                                                 uint32_t count, const float* points,
                                                 size_t point_count, float* spacings,
                                                 stp_distribution* distribution);
