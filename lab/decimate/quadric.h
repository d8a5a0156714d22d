// SPDX-License-Identifier: MIT
// Sums of squared distances from planes (Garland, Heckbert. Surface Simplification Using Quadric
// Error Metrics. 1997).
#pragma once

#include "base/math/math.h"

/// x' A x + 2 b' x + c.
typedef struct stp_quadric {
    double a[6]; ///< xx, xy, xz, yy, yz, zz
    stp_vec3d b;
    double c;
} stp_quadric;

/// Adds the plane through a point with a unit normal.
void stp_quadric_add_plane(stp_quadric* quadric, stp_vec3d point, stp_vec3d normal);
stp_quadric stp_quadric_sum(const stp_quadric* a, const stp_quadric* b);
/// The value at a point; never below 0.
double stp_quadric_at(const stp_quadric* quadric, stp_vec3d point);
/// Sum of the squared normals: the number of planes.
double stp_quadric_planes(const stp_quadric* quadric);
/// Point of minimum value. Stays near `start` along directions in which the value hardly changes
/// (less than a thousandth of the mean); returns `start` if the minimum is farther away than
/// `reach`.
stp_vec3d stp_quadric_minimum(const stp_quadric* quadric, stp_vec3d start, double reach);
