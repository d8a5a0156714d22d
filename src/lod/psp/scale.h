// SPDX-License-Identifier: MIT
// Merge units: model units times a power of two.
#pragma once

#include "lod/psp/ellipse.h"

#include <assert.h>

/// Power of two that scales a bounding box diagonal to between 2^19 and 2^20; 1 if the diagonal is
/// 0 or not finite.
static inline float stp_psp_choose_scale(float diagonal)
{
    if (!(diagonal > 0.0f) || diagonal > FLT_MAX) {
        return 1.0f;
    }
    int exponent;
    (void)frexpf(diagonal, &exponent);
    exponent = 20 - exponent;
    return ldexpf(1.0f, exponent < 126 ? exponent : 126);
}

/// Converts an ellipse to model units.
static inline stp_ellipse stp_psp_scale_ellipse(const stp_ellipse* e, float scale)
{
    assert(scale > 0.0f);
    float back = 1.0f / scale;
    return (stp_ellipse){.center = stp_scale(e->center, back),
                         .normal = e->normal,
                         .major = stp_scale(e->major, back),
                         .minor = stp_max(e->minor * back, FLT_MIN)};
}

/// Model-space value of an error of 1.
static inline double stp_psp_error_unit(int power, float scale)
{
    assert(power >= 0 && scale > 0.0f);
    double unit = 1.0;
    for (int i = 0; i < power; ++i) {
        unit /= (double)scale;
    }
    return unit;
}
