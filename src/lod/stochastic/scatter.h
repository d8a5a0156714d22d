// SPDX-License-Identifier: MIT
// Covariance of the points of a region, its eigenvalues, and tests for flatness and edges (Bhakar, Luo, Mudur 2004, 2 and 4.2).
#pragma once

#include "base/math.h"

#include <stddef.h>

/// Sums over points that give mean and covariance. Coordinates should be small: relative to a nearby point.
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

/// All eigenvalues of a symmetric matrix, ascending, from the cubic equation's three real roots. Uses no function of the C library
/// except the square root, so the bits are the same everywhere.
void stp_symmetric_eigenvalues(const double matrix[6], double eigenvalues[3]);

/// The smallest eigenvalue of a positive semidefinite matrix, if it is far below the others. The sum of the reciprocals of all
/// three is a quotient of two coefficients of the cubic equation, and the smallest eigenvalue contributes nearly all of it. The
/// result is at most the smallest eigenvalue. It is substituted into the equation to check that it is a root (4.2).
/// @return false if the region is not flat
bool stp_smallest_eigenvalue(const double matrix[6], double* eigenvalue);

/// Unit eigenvector of an eigenvalue that differs from the other two; (0, 1, 0) if no direction stands out.
stp_vec3d stp_symmetric_eigenvector(const double matrix[6], double eigenvalue);

/// The smallest eigenvalue's share of the sum of all, 0 to 1/3; 0 for coincident points.
double stp_scatter_flatness(const double matrix[6]);

/// Whether that share is at most `threshold`, which is below 0.1. Uses stp_smallest_eigenvalue instead of solving the equation. May
/// return false for a flat region that is nearly a line.
bool stp_scatter_is_flat(const double matrix[6], double threshold);

/// Whether a point whose neighbours have these eigenvalues may lie on an edge: l0 is about l1, and l2 about 2 l0 (2), both to
/// within a factor of ten. At the edge of a cube the ratio is 1 : 3.6 : 7.2, and l0 is lower a little beside it.
bool stp_scatter_is_edge(const double eigenvalues[3]);
