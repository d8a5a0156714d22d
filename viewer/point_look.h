// SPDX-License-Identifier: MIT
// What colours the points of the shown scene have, which of their classes are drawn, and what a clicked point is.
#pragma once

#include "point_colors.h"

/// Of one file; all zero: own colours, all classes.
typedef struct point_look {
    int color;          ///< point_color
    bool has_range;     ///< somebody chose it
    double low, high;   ///< of the scale
    bool hides;         ///< some classes are not drawn
    uint8_t shown[256]; ///< whether a class is, where `hides`
    uint32_t scene;     ///< serial that the elevations are of; 0: not known
    double elevation[2];
} point_look;
