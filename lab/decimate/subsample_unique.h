// SPDX-License-Identifier: MIT
// Removes duplicate points: otherwise coincident points would only have each other as neighbours.
#pragma once

#include "lab/decimate/decimator.h"

/// Sums of the colours of equal points, in linear light.
typedef struct stp_subsample_color {
    float sum[3];
    float count; ///< number of points
} stp_subsample_color;

typedef struct stp_subsample_unique {
    uint32_t count;
    float* positions;            ///< 3 per point, in input order
    float* normals;              ///< NULL if the input has none, or 3 per point
    stp_subsample_color* colors; ///< NULL if the input has none
} stp_subsample_unique;

/// Keeps one of all points with the same position and normal.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_subsample_unique_destroy, also
///         after a failure
STP_MUST_USE stp_result stp_subsample_unique_make(stp_context* context,
                                                  const stp_decimate_input* input,
                                                  stp_subsample_unique* unique);
void stp_subsample_unique_destroy(stp_context* context, stp_subsample_unique* unique);

/// Mean of summed colours, sRGB.
void stp_subsample_mean_color(const stp_subsample_color* sum, uint8_t color[3]);
