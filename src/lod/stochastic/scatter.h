// SPDX-License-Identifier: MIT
// How points scatter about their mean: the covariance matrix of a region, its eigenvalues and what they tell (Bhakar, Luo, Mudur
// 2004, 2 and 4.2).
#pragma once

#include "base/math.h"

#include <stddef.h>

/// Sums over points, from which follow mean and covariance. Coordinates should be small numbers: relative to a point near by.
typedef struct stp_scatter {
    double count, x, y, z;
    double xx, xy, xz, yy, yz, zz;
} stp_scatter;

void stp_scatter_add(stp_scatter* scatter, double x, double y, double z);

/// Adds the points of another scatter, each of them `weight` times.
/// @param from where the other's coordinates begin
void stp_scatter_merge(stp_scatter* scatter, const stp_scatter* other, double weight,
                       const double from[3]);

/// The covariance matrix: xx, xy, xz, yy, yz, zz. All 0 without points.
void stp_scatter_matrix(const stp_scatter* scatter, double matrix[6]);

/// All eigenvalues of a symmetric matrix, ascending: the cubic equation has three real roots, which are found directly.
/// Without functions of the C library beside the square root: the same bits everywhere.
void stp_symmetric_eigenvalues(const double matrix[6], double eigenvalues[3]);

/// The smallest eigenvalue of a matrix that has no negative ones, where it is far below the others: the sum of the reciprocals of
/// all three is the quotient of two coefficients of the cubic equation, and the smallest one's is nearly all of that sum. What
/// comes out is at most the smallest eigenvalue, and put back into the equation to see whether it is a root (4.2).
/// @return false if the region is not flat
bool stp_smallest_eigenvalue(const double matrix[6], double* eigenvalue);

/// The eigenvector of unit length of an eigenvalue that differs from the other two; (0, 1, 0) where no direction stands out.
stp_vec3d stp_symmetric_eigenvector(const double matrix[6], double eigenvalue);

/// The smallest eigenvalue's share of the sum of all, 0 to 1/3; of points in one place 0.
double stp_scatter_flatness(const double matrix[6]);

/// Whether that share is at most `threshold`, which is below 0.1: by stp_smallest_eigenvalue alone, without solving the equation.
/// May say no to a region that is as flat as that, but nearly a line.
bool stp_scatter_is_flat(const double matrix[6], double threshold);

/// Whether a point with such neighbours may lie on an edge: l0 is about l1, and l2 about 2 l0 (2). Both to within a factor of
/// ten: at the edge of a cube the ratio is 1 : 3.6 : 7.2, and a little beside it l0 is less.
bool stp_scatter_is_edge(const double eigenvalues[3]);
