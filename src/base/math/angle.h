// SPDX-License-Identifier: MIT
// Sine and cosine from basic arithmetic only, so the bits are the same on every machine. C
// libraries do not promise that.
#pragma once

#include <math.h>

/// `angle` is in radians, up to 10^6 in size; the error is below 10^-15. Both results are NaN for
/// larger or non-finite angles.
static inline void stp_sine_cosine(double angle, double* sine, double* cosine)
{
    // quarter turn split in two parts: products of the first part with integers are exact
    static const double quarter_high = 1.57079632673412561417e+00,
                        quarter_low = 6.07710050650619224932e-11;
    if (!(fabs(angle) <= 1e6)) {
        *sine = *cosine = (double)NAN;
        return;
    }
    double turns = floor(angle * 0.63661977236758134308 + 0.5);
    double x = angle - turns * quarter_high - turns * quarter_low, square = x * x;
    double s = 1.0, c = 1.0;
    for (int i = 9; i >= 1; --i) { // Taylor series: the first omitted term is below 10^-17
        s = 1.0 - s * square / (double)((2 * i) * (2 * i + 1));
        c = 1.0 - c * square / (double)((2 * i - 1) * (2 * i));
    }
    s *= x;
    int quarter = (int)turns & 3;
    double a = (quarter & 1) != 0 ? c : s, b = (quarter & 1) != 0 ? s : c;
    *sine = quarter >= 2 ? -a : a;
    *cosine = quarter == 1 || quarter == 2 ? -b : b;
}
