// SPDX-License-Identifier: MIT
// Dragging a plane along its normal with the pointer. Pure arithmetic: no window.
#pragma once

#include "program/present/navigate.h"

enum { STP_PLANE_CORNERS_MAX = 6 };

/// Intersection of a plane and a box: a convex polygon, in order around it. @return the number of
/// its corners; 0: no intersection
int stp_plane_cut_box(stp_vec3d point, stp_vec3d normal, const stp_boxd* box,
                      stp_vec3d corners[STP_PLANE_CORNERS_MAX]);

/// How far an anchor moves along a unit direction to follow the pointer between two picture
/// positions (pixels, y down). If the camera looks along the direction, moving up moves it away
/// from the viewer. 0 if the anchor is not in front of the eye.
double stp_plane_drag(const stp_navigator* n, stp_vec3d anchor, stp_vec3d direction,
                      const double from[2], const double to[2]);
