// SPDX-License-Identifier: MIT
// Positions of the splats in a set.
#pragma once

#include "base/math/math.h"
#include "base/splats/splat_columns.h"

/// Position of a splat in the space of its set's node.
static inline stp_vec3d stp_splat_place(const stp_splats* set, size_t index)
{
    const uint16_t* at = set->positions + 3 * index;
    double step = (double)set->step;
    return (stp_vec3d){(double)set->origin.x + step * (double)at[0],
                       (double)set->origin.y + step * (double)at[1],
                       (double)set->origin.z + step * (double)at[2]};
}
