// SPDX-License-Identifier: MIT
//
// Which boxes of an item's space are outside the picture, and how deep they begin.
#pragma once

#include "base/math.h"

/// Planes that bound what is seen: a point p of the item's space, less its offset, with a.p + b < 0 is not.
typedef struct stp_bounding {
    double a[5][3], b[5];
    double offset[3];
    float depth[4]; ///< the row of W
    float shift[3]; ///< the offset
} stp_bounding;

/// The sides of a picture, one pixel further out, and the near plane.
/// @param rows  an item's space, less `offset`, to the screen: x, y, nearness, W
stp_bounding stp_bounding_make(const float rows[4][4], float nearness_limit, const float offset[3],
                               uint32_t width, uint32_t height);
/// Whether the whole box lies behind one of the planes, with a margin for what floats round.
bool stp_bounding_misses(const stp_bounding* bounding, stp_box box);
/// The least depth (W) of a box.
float stp_bounding_least_depth(const stp_bounding* bounding, stp_box box);
