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

/// An ellipse of known directions that grows until it covers what is added.
typedef struct stp_ellipse_fit {
    stp_vec3 center, normal;
    stp_vec3 major, minor; ///< directions of the axes, of unit length
    float ratio;           ///< of the minor axis to the major one, 0.001 to 1
    float scale;           ///< length of the major axis so far
} stp_ellipse_fit;

/// Begins with axes that are `least` long or longer. Their directions and ratio are those of a scatter in the plane across
/// `normal`, along the axes of stp_disk_axes_across (base/coverage.h): the sums of squares xx and yy, and of products xy.
stp_ellipse_fit stp_ellipse_fit_begin(stp_vec3 center, stp_vec3 normal, double xx, double xy,
                                      double yy, float least);
/// Grows until the ellipse covers the projection of a point.
void stp_ellipse_fit_add(stp_ellipse_fit* fit, stp_vec3 point);
stp_ellipse stp_ellipse_fit_end(const stp_ellipse_fit* fit);

/// The direction in which points spread least about their mean: the eigenvector of the least eigenvalue of a symmetric
/// matrix (xx, xy, xz, yy, yz, zz), of unit length, and all eigenvalues, ascending.
stp_vec3d stp_least_direction(const double matrix[6], double eigenvalues[3]);
