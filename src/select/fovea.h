// SPDX-License-Identifier: MIT
//
// Larger splats away from where an eye looks (Brandt 4.4).
#pragma once

#include "select/view_frame.h"

enum { STP_FOVEA_ZONES = 8 };

/// The size of splats is multiplied by 1 where the eye looks, by `factor` at each zone's radius and beyond the last, and by
/// what lies linearly between in between.
typedef struct stp_fovea_zone {
    float radius; ///< of half the diagonal of the eye's picture; at least 0
    float factor; ///< above 0
} stp_fovea_zone;

typedef struct stp_fovea {
    uint32_t count; ///< of zones, by ascending radius; 0: the same size everywhere
    stp_fovea_zone zones[STP_FOVEA_ZONES];
    /// Where each eye looks: right and down from the middle of its picture, in halves of its diagonal.
    float center[2];
} stp_fovea;

/// Whether numbers are finite and in range, and radii ascend.
bool stp_fovea_is_valid(const stp_fovea* fovea);

double stp_fovea_factor(const stp_fovea* fovea, double radius);

/// The least and the greatest factor somewhere in a rectangle of an eye's picture.
void stp_fovea_bound(const stp_fovea* fovea, const stp_view_frame* frame,
                     const stp_view_rectangle* rectangle, double* least, double* greatest);
