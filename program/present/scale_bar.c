// SPDX-License-Identifier: MIT
#include "program/present/scale_bar.h"

#include <assert.h>
#include <math.h>

stp_scale_bar stp_scale_bar_make(double pixel, double max_pixels)
{
    static const double steps[] = {5.0, 2.0, 1.0};
    double maximum = pixel * max_pixels;
    if (!(pixel > 0.0) || !(max_pixels > 0.0) || !isfinite(maximum) || !(maximum > 1e-300)) {
        return (stp_scale_bar){0};
    }
    double power = pow(10.0, floor(log10(maximum)));
    for (int i = 0; i < 3; ++i) {
        double length = steps[i] * power;
        // log10 may be off by one rounding: the tenth of the power is the last resort
        if (length <= maximum) {
            return (stp_scale_bar){length, length / pixel};
        }
    }
    assert(0.5 * power <= maximum && "the bar fits");
    return (stp_scale_bar){0.5 * power, 0.5 * power / pixel};
}
