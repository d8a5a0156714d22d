// SPDX-License-Identifier: MIT
// Cameras that everybody expects: front, right, top, iso, ... framing a box.
#pragma once

#include "base/math.h"

#include <stipple/view.h>

/// Share of the picture's width or height that stays free on each side of a framed box.
#define STP_CAMERA_MARGIN 0.04

/// Names of the standard views, NULL at the end: front back left right top bottom iso and the 26 directions
/// "d0".."d25" that stay as far as possible from the capture's.
const char* const* stp_camera_names(void);
bool stp_camera_is_standard(const char* name);

/// Sets eye, target and up of `view` to a standard view that fits the box (see stp_camera_fit; a fov of 0 becomes 60).
/// @return false where there is no standard view of that name
bool stp_camera_frame(const char* name, const stp_boxd* box, stp_view* view);

/// Moves the eye, without turning it, to the nearest place from which every corner of what the view's sections leave of the
/// box lies within the picture, STP_CAMERA_MARGIN away from its border. At least two opposite sides of that frame are
/// touched; along the other direction the margins are equal. In parallel projection the height changes too.
///
/// Read: the directions, fov, width, height, eye_distance, ortho_height and sections. The target becomes the point of the
/// gaze beside the middle of the box. An empty box is replaced by a cube of side 2; a box that is cut away whole, and
/// sections that cannot be used, by the whole box.
void stp_camera_fit(stp_view* view, const stp_boxd* box);
