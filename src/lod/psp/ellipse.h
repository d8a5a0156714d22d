// SPDX-License-Identifier: MIT
// Elliptical splats, and the ellipse that holds points of a plane (Wu, Zhang, Kobbelt 2005, 3 and
// 4).
#pragma once

#include "base/math.h"

/// An ellipse in space: center + s major + t minor, s s + t t <= 1. The minor axis is normal x
/// major, scaled.
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

enum { STP_ELLIPSE_COVER_MOST = 2 * STP_ELLIPSE_SAMPLES }; ///< points that an ellipse is put around

/// An ellipse in the plane through `center` across `normal` that covers the projections of points,
/// and has almost the smallest area of all that do. Its centre is not `center`, but lies in that
/// plane. Where points lie along a line, the minor axis is a thousandth of the major one; where all
/// are one point, both are `least`. Without points, it is a disk around `center`.
/// @param normal of unit length
/// @param count at most STP_ELLIPSE_COVER_MOST
/// @param least above 0: the least length of an axis
stp_ellipse stp_ellipse_cover(stp_vec3 center, stp_vec3 normal, const stp_vec3* points,
                              size_t count, float least);

/// An ellipse around points that are not in one array: begin, scatter all points, turn, reach all
/// points, end. Its axes are those of the points' scatter about the centre, as long to each other
/// as its square roots, and scaled together.
typedef struct stp_ellipse_fit {
    stp_vec3 center, normal, x, y;
    double xx, xy, yy;
    stp_vec3 major, minor; ///< of unit length
    float ratio, scale;    ///< minor to major axis; length of the major axis
} stp_ellipse_fit;

stp_ellipse_fit stp_ellipse_fit_begin(stp_vec3 center, stp_vec3 normal);
void stp_ellipse_fit_scatter(stp_ellipse_fit* fit, stp_vec3 point);
void stp_ellipse_fit_turn(stp_ellipse_fit* fit, float least);
void stp_ellipse_fit_reach(stp_ellipse_fit* fit, stp_vec3 point);
stp_ellipse stp_ellipse_fit_end(const stp_ellipse_fit* fit);

/// The least eigenvalue of a symmetric matrix (xx, xy, xz, yy, yz, zz) that has no negative ones;
/// rounding may make it slightly negative.
double stp_least_eigenvalue(const double matrix[6]);

/// The direction in which points spread least about their mean: the eigenvector of the least
/// eigenvalue of a symmetric matrix (xx, xy, xz, yy, yz, zz), of unit length, and all eigenvalues,
/// ascending.
stp_vec3d stp_least_direction(const double matrix[6], double eigenvalues[3]);

/// The same direction alone, of a matrix that has no negative eigenvalues, such as a scatter.
stp_vec3d stp_scatter_normal(const double matrix[6]);
