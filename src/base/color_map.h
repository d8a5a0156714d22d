// SPDX-License-Identifier: MIT
// Colours for numbers: an even scale, and colours that are told apart. All sRGB.
#pragma once

#include <stdint.h>

/// Violet, blue, green, yellow: lightness rises evenly (scripts/make_color_map.py).
extern const uint8_t stp_color_map[256][3];

enum { STP_DISTINCT_COLORS = 24, STP_POINT_CLASSES = 23 };

/// Colours that are easily told apart; of a number, that of its remainder.
extern const uint8_t stp_distinct_colors[STP_DISTINCT_COLORS][3];

/// Colours of the classes of points that ASPRS LAS 1.4 numbers 0 to 22.
extern const uint8_t stp_class_colors[STP_POINT_CLASSES][3];

/// The name of a class of points in ASPRS LAS 1.4, table 17: "ground". NULL: it has none.
const char* stp_class_name(uint32_t number);

/// Of any class: 0 to 22 those above, others distinct ones.
const uint8_t* stp_class_color(uint32_t number);

/// The place of a value on the even scale, 0 at `low` or less to 255 at `high` or more.
static inline uint32_t stp_color_map_place(double value, double low, double high)
{
    double part = high > low ? (value - low) / (high - low) : value > low ? 1.0 : 0.0;
    return part > 0.0 ? (part < 1.0 ? (uint32_t)(part * 255.0 + 0.5) : 255) : 0;
}
