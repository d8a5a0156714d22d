// SPDX-License-Identifier: MIT
//
// The views of the eyes that a view has: one, or two that look side by side (stp_view.eye_distance).
#pragma once

#include <stipple/view.h>

enum { STP_EYES_MOST = 2 };

/// How many eyes a view has.
static inline uint32_t stp_view_eye_count(const stp_view* view)
{
    return view->eye_distance > 0.0 ? 2 : 1;
}

/// The view of one eye: of the view's size where there is one eye, else of half its width (an odd column is lost). Eyes look
/// in parallel, so depths along the gaze are the same for both.
stp_view stp_view_of_eye(const stp_view* view, uint32_t eye);
