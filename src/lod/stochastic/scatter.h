// SPDX-License-Identifier: MIT
// Scatter of points about their mean: the covariance matrix of a region and its eigenvalues
// (Bhakar, Luo, Mudur 2004, sections 2 and 4.2).
#pragma once

#include "base/math/math.h"

#include <stddef.h>

/// Sums over points, from which mean and covariance follow. For precision, coordinates should be
/// relative to a point nearby.
typedef struct stp_scatter {
    double count, x, y, z;
    double xx, xy, xz, yy, yz, zz;
} stp_scatter;

void stp_scatter_add(stp_scatter* scatter, double x, double y, double z);

/// Adds the points of another scatter, each with a weight.
/// @param from origin of the other scatter's coordinates
void stp_scatter_merge(stp_scatter* scatter, const stp_scatter* other, double weight,
                       const double from[3]);

/// The covariance matrix: xx, xy, xz, yy, yz, zz. All 0 without points.
void stp_scatter_matrix(const stp_scatter* scatter, double matrix[6]);

/// All eigenvalues of a symmetric matrix, ascending, from the three real roots of the
/// characteristic polynomial. The only library function used is the square root, so results are the
/// same on every machine.
void stp_symmetric_eigenvalues(const double matrix[6], double eigenvalues[3]);

/// Smallest eigenvalue of a positive semidefinite matrix, if it is far below the others. The sum of
/// the reciprocals of all three is the ratio of two coefficients of the characteristic polynomial,
/// and the smallest one dominates that sum. The estimate is at most the smallest eigenvalue; it is
/// accepted if it is almost a root of the polynomial (4.2).
/// @return false if the region is not flat, or nearly a line
bool stp_smallest_eigenvalue(const double matrix[6], double* eigenvalue);

/// Unit eigenvector of an eigenvalue that differs from the other two; (0, 1, 0) if no direction is
/// distinct.
stp_vec3d stp_symmetric_eigenvector(const double matrix[6], double eigenvalue);

/// Share of the smallest eigenvalue in the sum of all, 0 to 1/3; 0 if all points coincide.
double stp_scatter_flatness(const double matrix[6]);

/// Whether that share is at most `threshold`, which is below 0.1. Uses only
/// stp_smallest_eigenvalue. May return false for a region that is flat but nearly a line.
bool stp_scatter_is_flat(const double matrix[6], double threshold);

/// Whether a point with these neighbours may lie on an edge: l0 is about l1, and l2 about 2 l0
/// (section 2), each within a factor of ten. At the edge of a cube the ratio is 1 : 3.6 : 7.2;
/// slightly beside it l0 is smaller.
bool stp_scatter_is_edge(const double eigenvalues[3]);
