// SPDX-License-Identifier: MIT
// Planes that a hand drags along their normal in a picture. Pure arithmetic: no window.
#pragma once

#include "present/navigate.h"

enum { STP_PLANE_CORNERS_MOST = 6 };

/// Where a plane cuts a box: a convex polygon, in order around it. @return its corners; below 3: they do not meet
int stp_plane_cut_box(stp_vec3d point, stp_vec3d normal, const stp_boxd* box,
                      stp_vec3d corners[STP_PLANE_CORNERS_MOST]);

/// How far along a direction (unit) an anchor goes to follow the hand from one place of the picture to another (pixels, y down).
/// Where the camera looks along the direction, moving up moves it away from the viewer. 0 where the anchor is not before the eye.
double stp_plane_drag(const stp_navigator* n, stp_vec3d anchor, stp_vec3d direction,
                      const double from[2], const double to[2]);
