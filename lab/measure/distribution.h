// SPDX-License-Identifier: MIT
//
// How evenly the prefixes of an order are spaced, and how well they cover (Brandt 3.3).
#pragma once

#include "base/core/context.h"
#include "program/options/command.h"

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

// Figure 3 of Brandt et al. 2019: violin and box plots of the spacings of prefixes, orders side by
// side.

/// One violin: the spacings of one prefix of one order, relative to the largest even spacing.
typedef struct plot_violin {
    const char* label; ///< name of the order
    uint32_t count;    ///< points of the prefix
    float* values;     ///< ascending; owned by the caller
    uint32_t value_count;
} plot_violin;

/// Writes an SVG: violins of the same count are grouped, in the given order. Failures are logged.
STP_MUST_USE stp_result plot_violins(stp_context* context, const char* path,
                                     const plot_violin* violins, size_t violin_count);

// Exact nearest neighbours among a fixed set of points: a balanced kd-tree without pointers.

typedef struct stp_nearest {
    uint32_t count;
    float* positions; ///< 3 each, in the tree's order: the middle of each range splits it
    uint32_t* ids;    ///< their indices in the input
    uint8_t* axes;    ///< the axis that each splits
} stp_nearest;

/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_nearest_create(stp_context* context, stp_nearest* tree,
                                           const float* points, uint32_t count);
void stp_nearest_destroy(stp_context* context, stp_nearest* tree);

/// Squared distance from a point to the nearest one whose index is not `except` (UINT32_MAX: any);
/// infinity if there is none. Any thread.
double stp_nearest_squared(const stp_nearest* tree, const float* point, uint32_t except);
