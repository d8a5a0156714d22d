// SPDX-License-Identifier: MIT
// Elliptical splats, and enclosing ellipses of points in a plane (Wu, Zhang, Kobbelt 2005, sections
// 3 and 4).
#pragma once

#include "base/math/math.h"

/// An ellipse in space: center + s major + t minor, s s + t t <= 1. The minor axis is normal x
/// major, scaled.
typedef struct stp_ellipse {
    stp_vec3 center;
    stp_vec3 normal; ///< unit normal of its plane
    stp_vec3 major;  ///< length and direction of the semi-major axis
    float minor;     ///< length of the semi-minor axis, above 0 and at most that of `major`
} stp_ellipse;

enum { STP_ELLIPSE_SAMPLES = 8 }; ///< number of samples of a boundary

float stp_ellipse_area(const stp_ellipse* ellipse);

/// Points evenly spaced on the boundary, by angle from the major axis.
void stp_ellipse_sample(const stp_ellipse* ellipse, stp_vec3 samples[STP_ELLIPSE_SAMPLES]);

enum { STP_ELLIPSE_COVER_MAX = 2 * STP_ELLIPSE_SAMPLES }; ///< maximum points to enclose

/// Ellipse in the plane through `center` with `normal` that covers the projections of points, with
/// almost the smallest area. Its centre may differ from `center`, but lies in that plane. For
/// points along a line, the minor axis is a thousandth of the major one; if all coincide, both are
/// `minimum`. Without points, it is a disk around `center`.
/// @param normal of unit length
/// @param count at most STP_ELLIPSE_COVER_MAX
/// @param minimum above 0: minimum length of an axis
stp_ellipse stp_ellipse_cover(stp_vec3 center, stp_vec3 normal, const stp_vec3* points,
                              size_t count, float minimum);

/// Ellipse around points that are not in one array. Call begin, scatter with each point, orient,
/// expand with each point, end. Its axes are the principal axes of the points about the centre, in
/// the ratio of their standard deviations.
typedef struct stp_ellipse_fit {
    stp_vec3 center, normal, x, y;
    double xx, xy, yy;
    stp_vec3 major, minor; ///< unit directions of the axes
    float ratio, scale;    ///< minor to major axis; length of the major axis
} stp_ellipse_fit;

stp_ellipse_fit stp_ellipse_fit_begin(stp_vec3 center, stp_vec3 normal);
void stp_ellipse_fit_scatter(stp_ellipse_fit* fit, stp_vec3 point);
void stp_ellipse_fit_orient(stp_ellipse_fit* fit, float minimum);
void stp_ellipse_fit_expand(stp_ellipse_fit* fit, stp_vec3 point);
stp_ellipse stp_ellipse_fit_end(const stp_ellipse_fit* fit);

/// Smallest eigenvalue of a symmetric matrix (xx, xy, xz, yy, yz, zz) without negative ones;
/// rounding may make it slightly negative.
double stp_scatter_eigenvalue(const double matrix[6]);

/// Direction of least spread about the mean: the unit eigenvector of the smallest eigenvalue of a
/// symmetric matrix (xx, xy, xz, yy, yz, zz); also returns all eigenvalues, ascending.
stp_vec3d stp_scatter_eigenvector(const double matrix[6], double eigenvalues[3]);

/// Unit eigenvector of the smallest eigenvalue of a matrix without negative eigenvalues, such as a
/// scatter. Faster than stp_scatter_eigenvector where the eigenvalues are well separated.
stp_vec3d stp_scatter_normal(const double matrix[6]);
