// SPDX-License-Identifier: MIT
// The corners of what section planes leave of a box.
#pragma once

#include "base/math/math.h"

#include <stipple/view.h>

enum {
    STP_BOX_CLIP_PLANES = 6 + STP_SECTION_PLANES,
    /// At most: where three planes meet
    STP_BOX_CLIP_CORNERS =
        STP_BOX_CLIP_PLANES * (STP_BOX_CLIP_PLANES - 1) * (STP_BOX_CLIP_PLANES - 2) / 6,
};

/// Finds the corners of a box without what lies beyond any section plane, relative to the centre of
/// the box. The sections are in the space of the box; planes without a direction are ignored.
/// @return the number of corners; 0 if everything is cut away
uint32_t stp_box_clip(const stp_boxd* box, const stp_sections* sections,
                      stp_vec3d corners[STP_BOX_CLIP_CORNERS]);
