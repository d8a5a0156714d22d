// SPDX-License-Identifier: MIT
// Colours: the sRGB transfer function, and colours that show values and classes.
#pragma once

#include <stdint.h>

// The sRGB transfer function (IEC 61966-2-1) without the C library's pow, so the bits are the same
// everywhere.

/// Decodes one 8-bit channel to a linear value, 0..1.
float stp_srgb8_to_linear(uint8_t value);

/// Encodes a linear value as the 8-bit code whose decoded value is nearest. Clamps to 0..1; NaN
/// becomes 0.
uint8_t stp_linear_to_srgb8(float linear);

// Colours for values: an even scale and a set of distinct colours. All sRGB.

/// Violet, blue, green, yellow. Lightness rises evenly (scripts/make_color_map.py).
extern const uint8_t stp_color_map[256][3];

enum { STP_DISTINCT_COLORS = 24, STP_POINT_CLASSES = 23 };

/// Colours that are easy to tell apart. Index with the number modulo STP_DISTINCT_COLORS.
extern const uint8_t stp_distinct_colors[STP_DISTINCT_COLORS][3];

/// Colours of the ASPRS LAS 1.4 point classes 0 to 22.
extern const uint8_t stp_class_colors[STP_POINT_CLASSES][3];

/// Name of a point class, e.g. "ground" (ASPRS LAS 1.4, table 17); NULL if it has none.
const char* stp_class_name(uint32_t number);

/// Colour of any class: 0 to 22 from the table above, others from the distinct colours.
const uint8_t* stp_class_color(uint32_t number);

/// Index of a value in the even scale: 0 at `low` or less, 255 at `high` or more.
static inline uint32_t stp_color_map_place(double value, double low, double high)
{
    double part = high > low ? (value - low) / (high - low) : value > low ? 1.0 : 0.0;
    return part > 0.0 ? (part < 1.0 ? (uint32_t)(part * 255.0 + 0.5) : 255) : 0;
}
