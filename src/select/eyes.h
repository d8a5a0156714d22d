// SPDX-License-Identifier: MIT
// What the eyes see: their views, one or two side by side (stp_view.eye_distance), and larger splats
// away from the gaze point (Brandt 4.4).
#pragma once

#include "base/core/context.h"
#include "select/view_frame.h"

#include <stipple/view.h>

// Views of the eyes of a view: one, or two side by side (stp_view.eye_distance).

enum { STP_EYES_MAX = 2 };

/// Number of eyes of a view.
static inline uint32_t stp_view_eye_count(const stp_view* view)
{
    return view->eye_distance > 0.0 ? 2 : 1;
}

/// View of one eye: of the view's size for one eye, of half its width for two (an odd column is
/// lost). Viewing directions are parallel, so depths are the same for both eyes.
stp_view stp_view_of_eye(const stp_view* view, uint32_t eye);

/// Checks a view and the views of its eyes. @return STP_OK or STP_ERROR_ARGUMENT (logged)
STP_MUST_USE stp_result stp_view_check(stp_context* context, const stp_view* view);

// Foveated rendering: larger splats away from the gaze point (Brandt 4.4).

enum { STP_FOVEA_ZONES = 8 };

/// Factor on the splat size: 1 at the gaze point, `factor` at each zone's radius and beyond the
/// last, linear in between.
typedef struct stp_fovea_zone {
    float radius; ///< in half diagonals of the eye's picture; at least 0
    float factor; ///< above 0
} stp_fovea_zone;

typedef struct stp_fovea {
    uint32_t count; ///< number of zones, by ascending radius; 0: the same size everywhere
    stp_fovea_zone zones[STP_FOVEA_ZONES];
    /// Gaze point of each eye: right and down from the centre of its picture, in half diagonals.
    float center[2];
} stp_fovea;

/// Whether all numbers are finite and in range, and radii ascend.
bool stp_fovea_is_valid(const stp_fovea* fovea);

bool stp_fovea_is_same(const stp_fovea* a, const stp_fovea* b);

/// Minimum and maximum factor in a rectangle of an eye's picture.
void stp_fovea_bound(const stp_fovea* fovea, const stp_view_frame* frame,
                     const stp_view_rectangle* rectangle, double* minimum, double* greatest);
