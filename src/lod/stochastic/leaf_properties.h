// SPDX-License-Identifier: MIT
// Properties of each leaf of a cloud's octree (Bhakar, Luo, Mudur 2004, sections 2 and 3.1),
// estimated from a random sample of its points.
#pragma once

#include "lod/stochastic/leaf_octree.h"
#include "lod/stochastic/scatter.h"

/// Points on the grid of positions; normals come with the cloud or are estimated.
typedef struct stp_leaf_points {
    const uint16_t* positions; ///< 3 per point
    const float* normals;      ///< 3 per point, of unit length
    bool are_oriented;         ///< their signs are known
} stp_leaf_points;

/// Properties of a leaf. Lengths are in grid steps.
typedef struct stp_leaf_properties {
    float mean[3]; ///< mean position of its points
    /// Representative normal: of the plane through its points, or the mean of oriented normals
    stp_vec3 normal;
    float flatness; ///< l0 / (l0 + l1 + l2)
    float
        min_flatness; ///< lowest flatness of this and of larger scales (lod/stochastic/leaf_passes.h)
    float area;       ///< approximate surface area inside the leaf
    float spacing;    ///< side of the square that a point represents
    /// Sine of the angle to the representative normal that nine of ten normals do not exceed; 1:
    /// unbounded
    float spread;
    float ratio; ///< minor to major radius of its splats, from its principal curvatures
    /// Direction of the smaller curvature, along which splats are long; of unit length if `ratio`
    /// is below 1
    stp_vec3 stretch;
    bool known; ///< it has enough points for a plane
    bool edge;  ///< it may contain an edge
} stp_leaf_properties;

/// Computes plane, flatness, area and edge of each leaf, on all threads. Leaves with few points get
/// area and spacing 0.
/// @param scatters NULL, or receives the scatter of each leaf's sample, relative to its corner
void stp_leaf_measure_planes(stp_context* context, const stp_leaf_octree* octree,
                             const stp_leaf_points* points, stp_leaf_properties* properties,
                             stp_scatter* scatters);

/// Median spacing over the points of leaves with a spacing above 0. 0 without such leaves.
float stp_leaf_median_spacing(const stp_leaf_octree* octree, const stp_leaf_properties* properties);

/// Sets the representative normals if signs are known; otherwise they stay as
/// stp_leaf_measure_planes left them. On all threads.
void stp_leaf_measure_normals(stp_context* context, const stp_leaf_octree* octree,
                              const stp_leaf_points* points, stp_leaf_properties* properties);

/// Computes spread and curvature. The signs of normals may be arbitrary: each is turned to the side
/// of the leaf's normal. On all threads.
void stp_leaf_measure_curvature(stp_context* context, const stp_leaf_octree* octree,
                                const stp_leaf_points* points, stp_leaf_properties* properties);
