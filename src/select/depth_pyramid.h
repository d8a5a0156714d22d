// SPDX-License-Identifier: MIT
//
// What a picture hides: how near at least all pixels of a block are, for blocks of 8 x 8 pixels and blocks of blocks
// (Greene, Kass, Miller 1993). Made of a frame's nearness, asked about boxes before they are drawn.
#pragma once

#include "select/view_frame.h"

#include <stipple/base.h>

enum {
    STP_DEPTH_PYRAMID_BLOCK =
        8, ///< pixels a side of a block of level 0; blocks of the next are 2 x 2
    STP_DEPTH_PYRAMID_LEVELS = 16,
};

typedef struct stp_depth_pyramid {
    stp_view_frame frame; ///< the view that it is of
    uint32_t level_count; ///< 0: hides nothing
    uint32_t columns[STP_DEPTH_PYRAMID_LEVELS], rows[STP_DEPTH_PYRAMID_LEVELS];
    float*
        levels[STP_DEPTH_PYRAMID_LEVELS]; ///< the least nearness of each block; 0: background shows
    float* memory;
    size_t capacity;
} stp_depth_pyramid;

/// From the nearness of each pixel (stp_renderer_depth; one sample a pixel). All zero at first; memory is kept from call to
/// call. In parallel projection the pyramid hides nothing.
/// @return STP_OK, STP_ERROR_ARGUMENT (no view), STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_depth_pyramid_make(stp_context* context, const stp_view* view,
                                               const float* nearness, stp_depth_pyramid* pyramid);

/// The same for a frame already made, and also in parallel projection: there the blocks may be read, but
/// stp_depth_pyramid_hides must not be asked.
STP_MUST_USE stp_result stp_depth_pyramid_fill(stp_context* context, const stp_view_frame* frame,
                                               const float* nearness, stp_depth_pyramid* pyramid);

/// Whether nothing in the box, nor a splat that sticks out of it by at most `margin` pixels, can be seen in the
/// pyramid's own view, where what it was made of is still there, or up to `margin` pixels' sides behind its place. Never says so of what is in front of the near plane, or
/// wholly out of that view.
bool stp_depth_pyramid_hides(const stp_depth_pyramid* pyramid, const stp_boxd* box, double margin);

/// The same of a box in other coordinates: `rows` leads from them to right, down and depth in the pyramid's view.
bool stp_depth_pyramid_hides_placed(const stp_depth_pyramid* pyramid, const double rows[3][4],
                                    const stp_boxd* box, double margin);

void stp_depth_pyramid_destroy(stp_context* context, stp_depth_pyramid* pyramid);
