// SPDX-License-Identifier: MIT
// Distinct positions of points: merges coincident points.
#pragma once

#include "lab/decimate/point_disks.h"

typedef struct stp_distinct {
    uint32_t count;
    float* positions; ///< 3 per place
    /// 3 per place: means of its points, unit length or zero; NULL: the input has none
    float* normals;
    uint32_t* points;      ///< per position, its first point along the curve
    uint32_t* places;      ///< per point, the index of its position
    stp_color_mean* means; ///< per position, the mean colour of its points
} stp_distinct;

/// Lists positions along a space-filling curve, so that neighbours are close in memory
/// (stp_sort_spatially).
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); freed by stp_distinct_destroy, also after a
///         failure
STP_MUST_USE stp_result stp_distinct_make(stp_context* context, const stp_decimate_input* input,
                                          stp_distinct* distinct);
void stp_distinct_destroy(stp_context* context, stp_distinct* distinct);
