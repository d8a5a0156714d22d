// SPDX-License-Identifier: MIT
// The evenly spread samples of a node, from which methods other than `blue` make their sets.
#pragma once

#include "base/splats/splat_columns.h"
#include "lod/spt/point_tree.h"

/// Points made from a set of method `blue`, with its finest colours. Each is as large as the set's
/// drawn surfels, with its growth.
typedef struct stp_method_samples {
    stp_tree_points points;
    const uint8_t* coverages;   ///< 1 per point; owned by the set
    float *positions, *normals; ///< owned; those of `points`
    float* radii;               ///< owned; those of `points`; NULL without growths
} stp_method_samples;

/// @param set at least one surfel; its columns must outlive the samples
/// @param shadings of the set's surfels, for their growths; NULL: all are alike
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged). Freed by stp_method_samples_destroy, also
/// after a failure
STP_MUST_USE stp_result stp_method_samples_take(stp_context* context, const stp_splats* set,
                                                const stp_shading* shadings,
                                                stp_method_samples* samples);

/// Radius of the disk of a sample.
static inline float stp_method_samples_radius(const stp_method_samples* samples, size_t index)
{
    return samples->radii != NULL ? samples->radii[index] : samples->points.radius;
}

void stp_method_samples_destroy(stp_context* context, stp_method_samples* samples);
