// SPDX-License-Identifier: MIT
//
// A view as numbers: axes, focal length, near plane; and what of a box can be seen.
#pragma once

#include "base/math.h"

#include <stipple/view.h>

typedef struct stp_view_frame {
    stp_vec3d eye, right, down, forward; ///< unit axes, scene space
    double scale;              ///< pixels per unit of x/z; in parallel projection, per unit
    double center_x, center_y; ///< the pixel the gaze meets
    double near_distance; ///< perspective: above 0. Parallel: -infinity where nothing is cut off
    double width, height;
    bool parallel;
    // Half spaces beyond the sides of the picture, a pixel further out: side . (p - eye) > limit is not seen.
    stp_vec3d sides[4];
    double side_limits[4];
    double corner; ///< distance over depth in a corner of the picture; 1 in parallel projection
} stp_view_frame;

/// @return false where the view is not usable: no pixels, an angle out of range, numbers that are not finite, two
/// eyes (each has a frame of its own: select/eyes.h)
bool stp_view_frame_make(const stp_view* view, stp_view_frame* frame);

/// Whether some of the box may be in the picture, and if so from what depth on (along the gaze, never less than
/// the true one's lower bound, at least the near distance).
bool stp_view_frame_sees(const stp_view_frame* frame, const stp_boxd* box, double* nearest_depth);

/// The same, with the greatest depth of the box too.
bool stp_view_frame_sees_range(const stp_view_frame* frame, const stp_boxd* box,
                               double* nearest_depth, double* farthest_depth);

/// Pixels from x0 to x1 and from y0 to y1; within the picture.
typedef struct stp_view_rectangle {
    double x0, y0, x1, y1;
} stp_view_rectangle;

/// What holds the picture of the box, as far as it lies beyond the near plane; it changes continuously with the view.
/// Where it lies outside the picture, the points of the border next to it; where it lies before the near plane,
/// the whole picture.
stp_view_rectangle stp_view_frame_cover(const stp_view_frame* frame, const stp_boxd* box);

/// Side of a pixel at a depth, scene units.
double stp_view_frame_pixel_size(const stp_view_frame* frame, double depth);

/// Whether the eye is within the box. Never in parallel projection.
bool stp_view_frame_is_inside(const stp_view_frame* frame, const stp_boxd* box);
