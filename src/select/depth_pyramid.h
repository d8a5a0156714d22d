// SPDX-License-Identifier: MIT
//
// Hierarchical depth buffer for occlusion culling: the minimum nearness of all pixels of a block,
// for blocks of 4 x 4 pixels and blocks of blocks (Greene, Kass, Miller 1993). Built from a frame's
// nearness, and tested against boxes before they are drawn.
#pragma once

#include "select/view_frame.h"

#include <stipple/base.h>

enum {
    /// Side of a level 0 block in pixels; blocks of the next levels are 2 x 2
    STP_DEPTH_PYRAMID_BLOCK = 4,
    STP_DEPTH_PYRAMID_LEVELS = 16,
};

typedef struct stp_depth_pyramid {
    stp_view_frame frame; ///< the view it was made for
    /// How many times as far as they are its triangles lie, not less than 1 (draw/placement.h); 1
    /// unless set after stp_depth_pyramid_fill
    double pushed_back;
    uint32_t level_count; ///< 0: occludes nothing; else at least 2
    uint32_t columns[STP_DEPTH_PYRAMID_LEVELS], rows[STP_DEPTH_PYRAMID_LEVELS];
    /// Minimum nearness of each block; 0: background is visible
    float* levels[STP_DEPTH_PYRAMID_LEVELS];
    float* memory;
    size_t capacity;
} stp_depth_pyramid;

/// Builds the pyramid from the nearness of each pixel (stp_renderer_depth; one sample per pixel).
/// Zero-initialize it; memory is reused between calls. In parallel projection the blocks may be
/// read, but stp_depth_pyramid_hides must not be called. @return STP_OK, STP_ERROR_OUT_OF_MEMORY
/// (logged)
STP_MUST_USE stp_result stp_depth_pyramid_fill(stp_context* context, const stp_view_frame* frame,
                                               const float* nearness, stp_depth_pyramid* pyramid);

/// Whether the pyramid occludes the box and splats that extend beyond it by at most `margin`
/// pixels, in the pyramid's own view. Holds if the occluders are at their place or up to `margin`
/// pixel sides behind it. Returns false for boxes in front of the near plane or outside that view.
bool stp_depth_pyramid_hides(const stp_depth_pyramid* pyramid, const stp_boxd* box, double margin);

/// The same for a box in other coordinates: `rows` maps them to right, down and depth in the
/// pyramid's view.
bool stp_depth_pyramid_hides_placed(const stp_depth_pyramid* pyramid, const double rows[3][4],
                                    const stp_boxd* box, double margin);

/// Whether the pyramid occludes triangles in a box that are drawn pushed back as its own: exact but
/// for rounding. `rows` as above. They are drawn in float, relative to `offset`, which is in the
/// box's coordinates. Returns false for boxes that reach in front of the near plane or
/// lie outside that view.
bool stp_depth_pyramid_hides_triangles(const stp_depth_pyramid* pyramid, const double rows[3][4],
                                       const float offset[3], const stp_boxd* box);

void stp_depth_pyramid_destroy(stp_context* context, stp_depth_pyramid* pyramid);
