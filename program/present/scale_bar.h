// SPDX-License-Identifier: MIT
// Length of a scale bar: a round number that fits the available width.
#pragma once

typedef struct stp_scale_bar {
    double length; ///< 1, 2 or 5 times a power of ten; 0: no bar
    double pixels; ///< its width
} stp_scale_bar;

/// The longest bar of at most `max_pixels`, if a pixel is `pixel` units wide. No bar if either is
/// not positive and finite.
stp_scale_bar stp_scale_bar_make(double pixel, double max_pixels);
