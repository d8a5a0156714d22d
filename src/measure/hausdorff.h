// SPDX-License-Identifier: MIT
//
// How far a surface lies from what stands for it: one-sided Hausdorff distances, the largest and
// the mean (Wu, Zhang, Kobbelt 2005, 4 and 6), and how much area there is of either.
//
// A surface of triangles is sampled: every vertex of a triangle, and samples spread evenly over the
// area. Sample i of n belongs to the triangle that holds the area (i + 1/2) / n, triangles being
// laid in a row; within it, samples lie as a sequence of low discrepancy (Roberts, The Unreasonable
// Effectiveness of Quasirandom Sequences, 2018). So each triangle has as many samples as its share
// of the area, give or take one, and no random number is drawn. Where the largest distance may lie
// between samples, more is measured there (hausdorff_bound.h).
#pragma once

#include "measure/shape_tree.h"

/// A surface that is measured from: triangles, and points of their own. Arrays are the caller's.
/// All numbers are finite.
typedef struct stp_measured_surface {
    const float* positions; ///< 3 a vertex
    size_t vertex_count;
    const uint32_t* indices; ///< 3 a triangle, each below vertex_count
    size_t triangle_count;
    const float* points; ///< 3 a point
    size_t point_count;
} stp_measured_surface;

typedef struct stp_hausdorff {
    /// Largest distance that was found: of a vertex, sample or point, or between samples.
    double max;
    /// No place of the surface is farther: a thousandth above `max`, or more where the search ended
    /// early.
    double bound;
    /// Over samples and points, each counted once; of a surface without area over its vertices.
    double mean;
    stp_vec3d farthest; ///< where the largest is; of several the first
    double area;        ///< of the triangles
    uint64_t samples;   ///< distances that `mean` is of
} stp_hausdorff;

/// Samples of a surface that give a stable maximum: ten a triangle, at least 200,000 and at most
/// 4,000,000.
uint64_t stp_hausdorff_samples(size_t triangle_count);

/// Distances from the surface to the shapes of a tree, which must hold some. The same bits for any
/// number of threads.
/// @param samples of the area of the triangles; 0: vertices and points alone
/// @return STP_OK, STP_ERROR_ARGUMENT (nothing to measure from or to; logged),
///         STP_ERROR_OUT_OF_MEMORY (logged),
///         STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_hausdorff_measure(stp_context* context,
                                              const stp_measured_surface* surface,
                                              const stp_shape_tree* tree, uint64_t samples,
                                              stp_hausdorff* hausdorff);

/// Sum of the areas of disks and triangles.
double stp_shapes_area(const stp_shapes* shapes);
