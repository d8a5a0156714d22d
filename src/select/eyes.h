// SPDX-License-Identifier: MIT
//
// Views of the eyes of a view: one, or two side by side (stp_view.eye_distance).
#pragma once

#include <stipple/view.h>

enum { STP_EYES_MAX = 2 };

/// Number of eyes of a view.
static inline uint32_t stp_view_eye_count(const stp_view* view)
{
    return view->eye_distance > 0.0 ? 2 : 1;
}

/// View of one eye: of the view's size for one eye, of half its width for two (an odd column is
/// lost). Viewing directions are parallel, so depths are the same for both eyes.
stp_view stp_view_of_eye(const stp_view* view, uint32_t eye);
