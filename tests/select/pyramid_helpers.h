// SPDX-License-Identifier: MIT
// Depth pyramids of views, for tests of occlusion culling.
#pragma once

#include "select/depth_pyramid.h"

/// Builds the pyramid of a valid view in perspective from the nearness of each pixel.
static inline stp_result make_pyramid(stp_context* context, const stp_view* view,
                                      const float* nearness, stp_depth_pyramid* pyramid)
{
    stp_view_frame frame;
    return stp_view_frame_make(view, &frame)
               ? stp_depth_pyramid_fill(context, &frame, nearness, pyramid)
               : STP_ERROR_ARGUMENT;
}
