// SPDX-License-Identifier: MIT
// Pairs of neighbouring points are contracted, that of least quadric error first (Pauly, Gross,
// Kobbelt. Efficient Simplification of Point-Sampled Surfaces. 2002, 3.2).
#pragma once

#include "lod/decimate/distinct.h"
#include "lod/decimate/point_links.h"
#include "lod/decimate/quadric.h"

/// The best pair that a point is in.
typedef struct stp_contraction_pair {
    double error; ///< of the contracted point's quadric
    /// orders pairs of equal error: square of the length x the numbers of points that both stand
    /// for
    double weight;
    uint32_t partner; ///< UINT32_MAX: none
} stp_contraction_pair;

typedef struct stp_contraction {
    stp_context* context;
    stp_distinct* points;     ///< normals and means are added up where points are contracted
    const stp_ellipse* disks; ///< of points at first: their normals
    stp_point_links links;
    stp_vec3d middle; ///< positions are about it
    double least;     ///< error of a plane, below which it is rounding
    stp_vec3d* positions;
    stp_quadric* quadrics;
    stp_contraction_pair* pairs; ///< of points
    uint32_t* heap;              ///< points, the best pair's first
    uint32_t* places;            ///< of points in the heap; UINT32_MAX: not in it
    uint32_t* near;              ///< neighbours of one point
    uint32_t* near_near;         ///< those of one of them
    uint32_t heap_count;
    uint32_t left; ///< how many points there are
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
