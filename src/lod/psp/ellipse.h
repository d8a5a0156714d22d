// SPDX-License-Identifier: MIT
// Elliptical splats, and the ellipse that holds points of a plane (Wu, Zhang, Kobbelt 2005, 3 and 4).
#pragma once

#include "base/math.h"

/// An ellipse in space: center + s major + t minor, s s + t t <= 1. The minor axis is normal x major, scaled.
typedef struct stp_ellipse {
    stp_vec3 center;
    stp_vec3 normal; ///< of unit length
    stp_vec3 major;  ///< the larger axis with its length
    float minor;     ///< length of the smaller axis, above 0 and at most that of `major`
} stp_ellipse;

enum { STP_ELLIPSE_SAMPLES = 8 }; ///< of a boundary

float stp_ellipse_area(const stp_ellipse* ellipse);

/// Points spread evenly over the boundary, by angle from the major axis.
void stp_ellipse_sample(const stp_ellipse* ellipse, stp_vec3 samples[STP_ELLIPSE_SAMPLES]);

/// The ellipse in the plane through `center` across `normal` that covers the projections of points: its axes are those
/// of the points' scatter about the centre, as long to each other as its square roots, and scaled together. Where points lie
/// along a line, the minor axis is a thousandth of the major one; where all are one point, both are `least`.
/// @param normal of unit length
/// @param least above 0: the least length of an axis
stp_ellipse stp_ellipse_cover(stp_vec3 center, stp_vec3 normal, const stp_vec3* points,
                              size_t count, float least);

/// The direction in which points spread least about their mean: the eigenvector of the least eigenvalue of a symmetric
/// matrix (xx, xy, xz, yy, yz, zz), of unit length, and all eigenvalues, ascending.
stp_vec3d stp_least_direction(const double matrix[6], double eigenvalues[3]);
