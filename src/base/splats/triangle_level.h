// SPDX-License-Identifier: MIT
// Level of a triangle: largest splat radius at which the triangle is drawn instead (Dachsbacher et
// al. 2003, 3.8).
#pragma once

#include "base/math/math.h"

/// Half the longest side: at least two splats of that radius would be needed to cover the triangle.
static inline float stp_triangle_level(stp_vec3 a, stp_vec3 b, stp_vec3 c)
{
    stp_vec3 ab = stp_sub(b, a), ac = stp_sub(c, a), bc = stp_sub(c, b);
    float longest = stp_dot(ab, ab);
    longest = longest < stp_dot(ac, ac) ? stp_dot(ac, ac) : longest;
    longest = longest < stp_dot(bc, bc) ? stp_dot(bc, bc) : longest;
    return 0.5f * sqrtf(longest);
}
