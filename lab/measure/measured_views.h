// SPDX-License-Identifier: MIT
//
// Views of measurements. They stay the same when the program frames pictures in another way, so
// figures of different versions are comparable: 60 degrees, "iso" from (1, 0.8, 1.2), and the
// corners of the bounds fit the picture.
#pragma once

#include "base/math/math.h"
#include "store/file/store.h"

#include <stipple/view.h>

/// Sets eye, target, up and fov (if 0) of a standard view of a box. @return false if no standard
/// view has that name
bool measured_standard_view(const char* name, const stp_boxd* box, stp_view* view);

/// A named view of the file, or a standard view of its bounds. @return false if there is no such
/// view
bool measured_view(const stp_store* store, const char* name, stp_view* view);
