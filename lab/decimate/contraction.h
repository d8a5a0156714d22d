// SPDX-License-Identifier: MIT
// Contracts pairs of neighbouring points, the least quadric error first (Pauly, Gross, Kobbelt.
// Efficient Simplification of Point-Sampled Surfaces. 2002, 3.2).
#pragma once

#include "lab/decimate/distinct.h"
#include "lab/decimate/point_links.h"
#include "lab/decimate/quadric.h"

/// Best pair of a point.
typedef struct stp_contraction_pair {
    double error; ///< value of both quadrics at the contracted point; 0 if it is rounding noise
    /// Orders pairs of equal error: squared length x the numbers of represented points
    double weight;
    uint32_t partner; ///< UINT32_MAX: none
} stp_contraction_pair;

typedef struct stp_contraction {
    stp_context* context;
    stp_distinct* points;     ///< normals and means are summed on contraction
    const stp_ellipse* disks; ///< disks of the points; only their normals are read, to begin
    stp_point_links links;
    stp_vec3d middle; ///< origin of positions
    double minimum;   ///< error per plane; below it, an error is rounding noise
    stp_vec3d* positions;
    stp_quadric* quadrics;
    stp_contraction_pair* pairs; ///< best pair of each point
    uint32_t* heap;              ///< heap of points, the best pair first
    uint32_t* places;            ///< heap index of points; UINT32_MAX: not in it
    uint32_t* near;              ///< neighbours of one point
    uint32_t* near_near;         ///< those of one of them
    uint32_t heap_count;
    uint32_t left; ///< number of remaining points
} stp_contraction;

/// Prepares all pairs. `context`, `points` and `disks` are set; neighbours as in
/// stp_point_links_make.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged); freed by
///         stp_contraction_destroy, also after a failure
STP_MUST_USE stp_result stp_contraction_make(stp_contraction* c, const uint32_t* neighbours,
                                             uint32_t k);
/// Contracts the best pair. @return false if no pair is left
bool stp_contraction_step(stp_contraction* c);
void stp_contraction_destroy(stp_contraction* c);
