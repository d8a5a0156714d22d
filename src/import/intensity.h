// SPDX-License-Identifier: MIT
//
// Files say how strong an echo was in units of their own; the scene counts to 65535.
#pragma once

/// What becomes 0 and 65535.
typedef struct stp_intensity_range {
    double low, high;
} stp_intensity_range;

/// Judges by the least and the greatest value of a file that does not say its range: up to 1, to
/// 255 or to 65535, whichever suits; from -2048 to 2047 where one is negative; all others are
/// stretched from the least to the greatest. Of no value (low above high): up to 1.
static inline stp_intensity_range stp_intensity_judge(double low, double high)
{
    if (low >= -2048.0 && low < 0.0 && high <= 2047.0) {
        return (stp_intensity_range){-2048.0, 2047.0};
    }
    if (low <= high && (low < 0.0 || high > 65535.0)) {
        return (stp_intensity_range){low, high > low ? high : low + 1.0};
    }
    return (stp_intensity_range){0.0, high <= 1.0 ? 1.0 : high <= 255.0 ? 255.0 : 65535.0};
}

/// What a difference to `low` is multiplied with.
static inline double stp_intensity_factor(stp_intensity_range range)
{
    return 65535.0 / (range.high - range.low);
}

/// Rounds to a whole number up to `most`; clamped, not-a-number is 0.
static inline double stp_quantize(double value, double most)
{
    value = value > 0.0 ? value + 0.5 : 0.0;
    return value < most ? value : most;
}
