// SPDX-License-Identifier: MIT
// Colours of the scene's points, filter of classes, and properties of a clicked point.
#pragma once

#include "program/options/point_colors.h"

/// Settings of one file; all zero: own colours, all classes.
typedef struct point_style {
    int color;          ///< point_color
    bool has_range;     ///< the user chose a range
    double low, high;   ///< ends of the colour scale, if `has_range`
    bool hides;         ///< some classes are not drawn
    uint8_t shown[256]; ///< visible classes, if `hides`
    uint32_t scene;     ///< serial of the scene that the elevations belong to; 0: unknown
    double elevation[2];
} point_style;
