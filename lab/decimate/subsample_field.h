// SPDX-License-Identifier: MIT
// Properties of the points for splat sub-sampling: neighbours, own splats, areas and margins.
#pragma once

#include "lab/decimate/decimator.h"

// Removes duplicate points: otherwise coincident points would only have each other as neighbours.

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

/// Points with their neighbour graph. Positions, normals and colours belong to the caller.
typedef struct stp_subsample_field {
    uint32_t count;
    const float* positions;            ///< 3 per point
    const float* normals;              ///< NULL, or 3 per point: unit, or zero if unknown
    const stp_subsample_color* colors; ///< NULL: white
    stp_ellipse* own;                  ///< a disk of each point, as wide as its farthest neighbour
    uint32_t* starts;                  ///< per point, start of its `neighbours`; and the end
    uint32_t* neighbours;              ///< the 8 nearest of each point, in both directions
    uint32_t* weights;                 ///< area of each point, in 1/256 of the mean; 1 to 2^16
    float* margins;                    ///< radius of the surface that each point represents
    uint32_t* order;                   ///< points along a space-filling curve
    double diagonal;                   ///< bounding box diagonal; 1 if all points coincide
} stp_subsample_field;

/// Finds neighbours, normals and areas. Uses all threads; results do not depend on their number.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_subsample_field_destroy, also
///         after a failure
STP_MUST_USE stp_result stp_subsample_field_make(stp_context* context,
                                                 const stp_subsample_unique* points,
                                                 stp_subsample_field* field);
void stp_subsample_field_destroy(stp_context* context, stp_subsample_field* field);

/// Adds edges between the parts of the graph until all points are connected. Needed only if the
/// target is lower than the number of separate parts allows.
/// @param added receives the number of new edges; 0: the graph was connected
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged); the field stays valid
STP_MUST_USE stp_result stp_subsample_field_connect(stp_context* context,
                                                    stp_subsample_field* field, uint32_t* added);

static inline stp_vec3 stp_subsample_position(const stp_subsample_field* field, uint32_t point)
{
    const float* p = field->positions + 3 * (size_t)point;
    return (stp_vec3){p[0], p[1], p[2]};
}

/// Whether a splat of this normal may cover a point: the point does not face away from it.
static inline bool stp_subsample_same_side(const stp_subsample_field* field, uint32_t point,
                                           stp_vec3 normal)
{
    if (field->normals == NULL) {
        return true;
    }
    const float* n = field->normals + 3 * (size_t)point;
    return !(stp_dot((stp_vec3){n[0], n[1], n[2]}, normal) < 0.0f);
}
