// SPDX-License-Identifier: MIT
//
// What the directions of a capture miss. Grooves between fins, the inside of a bracket, the ground under a
// table: they are visible from outside, but not from the eight corners. So the object is drawn from further
// directions too (the middles of faces and edges), and of these pictures only that surface is kept which no
// candidate of the first ones stands for: none within a pixel's size on the same side. Surface that the first
// directions saw at a slant, and sampled thinly, is filled up likewise.
#pragma once

#include "capture/capture_internal.h"

enum { STP_CAPTURE_FILL_DIRECTIONS = 26 /**< a cube's corners, faces and edges */ };

/// Draws the further views after those that were drawn, and adds their bands to the job's. `views` has room
/// for STP_CAPTURE_FILL_DIRECTIONS more. Drawn already are `count` directions.
STP_MUST_USE stp_result stp_capture_draw_fill(stp_capture_job* job, uint32_t count,
                                              double pixel_size);

/// Takes those candidates out, of the ones from `first` on, that an earlier one below `first` stands for.
/// Order is kept. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_capture_keep_missing(stp_context* context, stp_candidates* candidates,
                                                 uint32_t first);
