// SPDX-License-Identifier: MIT
// Cameras that everybody expects: front, right, top, iso, ... framing a box.
#pragma once

#include "base/math.h"

#include <stipple/view.h>

/// Names of the standard views, NULL at the end: front back left right top bottom iso and the 26 directions
/// "d0".."d25" that stay as far as possible from the capture's.
const char* const* stp_camera_names(void);

/// Sets eye, target and up of `view` so that the box fills the picture (fov, width and height are read; a fov
/// of 0 becomes 60). @return false where there is no standard view of that name
bool stp_camera_frame(const char* name, const stp_boxd* box, stp_view* view);
