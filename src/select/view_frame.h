// SPDX-License-Identifier: MIT
//
// Camera frame of a view: axes, focal length, near plane; frustum tests of boxes.
#pragma once

#include "base/math/math.h"

#include <stipple/view.h>

typedef struct stp_view_frame {
    stp_vec3d eye, right, down, forward; ///< unit axes, scene space
    double scale;              ///< pixels per unit of x/z; in parallel projection, per unit
    double center_x, center_y; ///< principal point, in pixels
    double near_distance;      ///< above 0; parallel: -infinity if there is no near plane
    double width, height;
    bool parallel;
    // Frustum sides, one pixel outside the picture: points with side . (p - eye) > limit are not
    // visible.
    stp_vec3d sides[4];
    double side_limits[4];
    double corner; ///< distance over depth in a corner of the picture; 1 in parallel projection
} stp_view_frame;

/// The fault of a view's numbers or sections, as a clause; NULL: it has none.
const char* stp_view_find_fault(const stp_view* view);

/// @return false if the view has a fault, or two eyes (each has its own frame: select/eyes.h)
bool stp_view_frame_make(const stp_view* view, stp_view_frame* frame);

/// Whether part of the box may be in the picture, and its depths: nearest, a lower bound, at least
/// the near distance; and farthest, of the whole box.
bool stp_view_frame_depths(const stp_view_frame* frame, const stp_boxd* box, double* nearest_depth,
                           double* farthest_depth);

/// Pixels from x0 to x1 and from y0 to y1; within the picture.
typedef struct stp_view_rectangle {
    double x0, y0, x1, y1;
} stp_view_rectangle;

/// Rectangle that contains the projection of the box beyond the near plane; it changes continuously
/// with the view. For a box outside the picture, the nearest points of the border; for a box in
/// front of the near plane, the whole picture.
stp_view_rectangle stp_view_frame_cover(const stp_view_frame* frame, const stp_boxd* box);

/// Direction towards the key light, to the left of, above and behind the viewer: parts along the
/// frame's right, up and backward axes, as stp_view_frame_direction takes them.
extern const float stp_key_light[3];

/// A direction given by its parts along the right, up and backward axes, in scene space. Not
/// normalized.
stp_vec3d stp_view_frame_direction(const stp_view_frame* frame, const float along[3]);

/// Side of a pixel at a depth, in scene units.
double stp_view_frame_pixel_size(const stp_view_frame* frame, double depth);

/// Whether the eye is inside the box. Always false in parallel projection.
bool stp_view_frame_is_inside(const stp_view_frame* frame, const stp_boxd* box);
