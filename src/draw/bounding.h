// SPDX-License-Identifier: MIT
//
// Frustum culling of boxes in item space, and their nearest depth.
#pragma once

#include "base/math/math.h"

/// Frustum planes: a point p in item space, relative to the item's offset, with a.p + b < 0 is not
/// visible.
typedef struct stp_bounding {
    double a[5][3], b[5];
    double offset[3];
    float depth[4]; ///< the row of W
    float shift[3]; ///< the offset
} stp_bounding;

/// Makes the sides of a picture, one pixel outside it, and the near plane.
/// @param rows from item space, relative to `offset`, to the screen: x, y, nearness, W
stp_bounding stp_bounding_make(const float rows[4][4], float nearness_limit, const float offset[3],
                               uint32_t width, uint32_t height);
/// Whether the whole box lies behind one of the planes, with a margin for rounding.
bool stp_bounding_misses(const stp_bounding* bounding, stp_box box);
/// Minimum depth (W) of a box.
float stp_bounding_min_depth(const stp_bounding* bounding, stp_box box);
