// SPDX-License-Identifier: MIT
// Sine and cosine from basic arithmetic alone: the same bits on every machine, which C libraries do not promise.
#pragma once

#include <math.h>

/// Radians up to 10^6, to within 10^-15; of others, and of what is not finite, both are not-a-number.
static inline void stp_sine_cosine(double angle, double* sine, double* cosine)
{
    // a quarter turn in two parts: products of the first with whole numbers are exact
    static const double quarter_high = 1.57079632673412561417e+00,
                        quarter_low = 6.07710050650619224932e-11;
    if (!(fabs(angle) <= 1e6)) {
        *sine = *cosine = (double)NAN;
        return;
    }
    double turns = floor(angle * 0.63661977236758134308 + 0.5);
    double x = angle - turns * quarter_high - turns * quarter_low, square = x * x;
    double s = 1.0, c = 1.0;
    for (int i = 9; i >= 1; --i) { // Taylor's series: the first term left out is below 10^-17
        s = 1.0 - s * square / (double)((2 * i) * (2 * i + 1));
        c = 1.0 - c * square / (double)((2 * i - 1) * (2 * i));
    }
    s *= x;
    int quarter = (int)turns & 3;
    double a = (quarter & 1) != 0 ? c : s, b = (quarter & 1) != 0 ? s : c;
    *sine = quarter >= 2 ? -a : a;
    *cosine = quarter == 1 || quarter == 2 ? -b : b;
}
