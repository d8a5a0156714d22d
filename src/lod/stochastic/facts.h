// SPDX-License-Identifier: MIT
// What is known of each leaf of a cloud's octree (Bhakar, Luo, Mudur 2004, 2 and 3.1), each from a random choice of its points.
#pragma once

#include "lod/stochastic/leaf_octree.h"
#include "lod/stochastic/scatter.h"

/// Points on the grid of positions; normals come with the cloud or are estimated.
typedef struct stp_leaf_points {
    const uint16_t* positions; ///< 3 a point
    const float* normals;      ///< 3 a point, of unit length
    bool are_oriented;         ///< their signs are known
} stp_leaf_points;

/// Lengths are steps of the grid.
typedef struct stp_leaf_facts {
    float mean[3]; ///< of its points, on the grid
    stp_vec3
        normal; ///< representative: of the plane through its points, or the mean of oriented normals
    float flatness; ///< l0 / (l0 + l1 + l2)
    float lasting;  ///< flatness that larger scales show as well (lod/stochastic/scales.h)
    float area;     ///< of the surface in it, about
    float spacing;  ///< side of the square that a point stands for
    float
        spread;  ///< sine of how far nine of ten normals lie from the representative one; 1: or any
    float ratio; ///< of the smaller to the larger radius of its splats: of its principal curvatures
    stp_vec3
        stretch; ///< direction of the smaller curvature, in which splats are long; of unit length where `ratio` is below 1
    bool known;  ///< it has enough points for a plane
    bool edge;   ///< there may be an edge in it
} stp_leaf_facts;

/// Plane, flatness, area and edge of each leaf. Of a leaf of few points the usual spacing is taken. On all threads.
/// @param scatters NULL, or receives for each leaf that of its random choice, relative to its corner
void stp_leaf_facts_of_places(stp_context* context, const stp_leaf_octree* octree,
                              const stp_leaf_points* points, stp_leaf_facts* facts,
                              stp_scatter* scatters);

/// The median of all points' spacing: half of the points lie closer. 0 without leaves.
float stp_leaf_median_spacing(const stp_leaf_octree* octree, const stp_leaf_facts* facts);

/// The representative normal where signs are known; else it is as stp_leaf_facts_of_places left it. On all threads.
void stp_leaf_facts_of_normals(stp_context* context, const stp_leaf_octree* octree,
                               const stp_leaf_points* points, stp_leaf_facts* facts);

/// Spread and curvature, of normals on the side of the leaf's: either sign of a normal will do. On all threads.
void stp_leaf_facts_of_bends(stp_context* context, const stp_leaf_octree* octree,
                             const stp_leaf_points* points, stp_leaf_facts* facts);
