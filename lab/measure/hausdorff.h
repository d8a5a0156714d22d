// SPDX-License-Identifier: MIT
//
// One-sided Hausdorff distances from a surface to its approximation, maximum and mean (Wu, Zhang,
// Kobbelt 2005, 4 and 6), and the areas of both.
//
// A surface of triangles is sampled: at every vertex of a triangle, and evenly over the area.
// Sample i of n belongs to the triangle at cumulative area (i + 1/2) / n of the total; within it,
// samples follow a low-discrepancy sequence (Roberts, The Unreasonable Effectiveness of Quasirandom
// Sequences, 2018). So each triangle has as many samples as its share of the area, to within one,
// and no random numbers are needed. Where the maximum may lie between samples, more places are
// measured (hausdorff_bound.c).
#pragma once

#include "lab/measure/shape_tree.h"

/// The surface to measure from: triangles and separate points. The caller owns the arrays. All
/// numbers must be finite.
typedef struct stp_measured_surface {
    const float* positions; ///< 3 per vertex
    size_t vertex_count;
    const uint32_t* indices; ///< 3 per triangle, each below vertex_count
    size_t triangle_count;
    const float* points; ///< 3 per point
    size_t point_count;
} stp_measured_surface;

typedef struct stp_hausdorff {
    /// Largest distance found: at a vertex, sample or point, or between samples.
    double max;
    /// Upper bound: no place of the surface is farther. A thousandth above `max`, or more if the
    /// search ended early.
    double bound;
    /// Mean over samples and points; over vertices if there are neither.
    double mean;
    stp_vec3d farthest; ///< place of the maximum; the first if there are several
    double area;        ///< sum of the triangles' areas
    uint64_t samples;   ///< number of distances in `mean`
} stp_hausdorff;

/// Number of samples that gives a stable maximum: ten per triangle, at least 200,000 and at most
/// 4,000,000.
uint64_t stp_hausdorff_samples(size_t triangle_count);

/// Measures distances from the surface to the shapes of a non-empty tree. The same bits for any
/// number of threads.
/// @param samples over the area of the triangles; 0: only vertices and points
/// @return STP_OK, STP_ERROR_ARGUMENT (nothing to measure from or to; logged),
/// STP_ERROR_OUT_OF_MEMORY (logged), STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_hausdorff_measure(stp_context* context,
                                              const stp_measured_surface* surface,
                                              const stp_shape_tree* tree, uint64_t samples,
                                              stp_hausdorff* hausdorff);

/// Sum of the areas of disks and triangles.
double stp_shapes_area(const stp_shapes* shapes);

// Part of hausdorff.c: finds the largest distance between samples, with a proof.

/// Raises `max` and `farthest` to places that samples missed, and sets `bound`.
///
/// Two facts bound the distance within a triangle. A distance changes no faster than its place
/// moves: so no place is farther than the centre's distance plus the radius around the centre. And
/// the distance to a single disk or triangle is convex: so no place is farther from the shape
/// nearest to the centre than the farthest corner is. Triangles that these bounds do not rule out
/// are split into four, until no distance can exceed the maximum by more than a thousandth, or
/// `places` more were measured. The same bits for any number of threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged), STP_ERROR_CANCELLED
STP_MUST_USE stp_result stp_hausdorff_prove(stp_context* context,
                                            const stp_measured_surface* surface,
                                            const stp_shape_tree* tree, uint64_t places,
                                            stp_hausdorff* hausdorff);
