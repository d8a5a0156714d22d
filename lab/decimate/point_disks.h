// SPDX-License-Identifier: MIT
// Shared by decimators: disks of points, allocation of the output, and mean colours.
#pragma once

#include "lab/decimate/decimator.h"

enum { STP_DECIMATE_NEIGHBOURS = 8 }; ///< k of the paper (6)

static inline stp_vec3 stp_decimate_vector(const float* values, size_t index)
{
    return (stp_vec3){values[3 * index], values[3 * index + 1], values[3 * index + 2]};
}

/// @return STP_OK, or STP_ERROR_LIMIT (logged) if there are too many points
STP_MUST_USE stp_result stp_decimate_check(stp_context* context, const stp_decimate_input* input);

/// Bounding box of all points; without points, a point at 0.
stp_box stp_decimate_box(const stp_decimate_input* input);

/// A disk for each point (Wu, Zhang, Kobbelt 2005, 3). Coincident points have the same neighbours,
/// at other positions.
/// @param disks receives an array of input->count disks
/// @param neighbours receives STP_DECIMATE_NEIGHBOURS per point, UINT32_MAX if there are fewer;
///         NULL: not wanted. The caller frees both, also after a failure
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_decimate_make_disks(stp_context* context,
                                                const stp_decimate_input* input,
                                                stp_ellipse** disks, uint32_t** neighbours);

/// The same for points that rarely coincide. Takes quadratic time in the number of coincident
/// points.
STP_MUST_USE stp_result stp_decimate_make_distinct_disks(stp_context* context,
                                                         const stp_decimate_input* input,
                                                         stp_ellipse** disks,
                                                         uint32_t** neighbours);

/// Allocates `count` splats, and sets the output's count.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_decimate_make_room(stp_context* context, stp_decimate_output* output,
                                               uint32_t count);

/// A weighted mean of colours, in linear light.
typedef struct stp_color_mean {
    double sum[3], weight;
} stp_color_mean;

/// Adds the colour of a point.
void stp_color_mean_add(stp_color_mean* mean, const stp_decimate_input* input, size_t point,
                        double weight);
/// @param color receives 3 bytes, sRGB; white if all weights are 0
void stp_color_mean_write(const stp_color_mean* mean, uint8_t* color);
