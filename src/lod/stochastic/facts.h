// SPDX-License-Identifier: MIT
// Facts about the leaves of a cloud's octree (Bhakar, Luo, Mudur 2004, 2 and 3.1), each computed from a random sample of points.
#pragma once

#include "lod/stochastic/leaf_octree.h"
#include "lod/stochastic/scatter.h"

/// Points on the position grid. Normals come with the cloud or are estimated.
typedef struct stp_leaf_points {
    const uint16_t* positions; ///< 3 a point
    const float* normals;      ///< 3 a point, of unit length
    bool are_oriented;         ///< the signs of the normals are known
} stp_leaf_points;

/// Lengths are in grid steps.
typedef struct stp_leaf_facts {
    float mean[3]; ///< mean position, on the grid
    stp_vec3
        normal;     ///< representative normal: of the fitted plane, or the mean of oriented normals
    float flatness; ///< l0 / (l0 + l1 + l2)
    float lasting;  ///< flatness that larger scales show as well (lod/stochastic/scales.h)
    float area;     ///< approximate surface area
    float spacing;  ///< side of the square that each point represents
    float
        spread; ///< sine of the angle to the normal that nine of ten normals stay within; 1: unbounded
    float ratio; ///< smaller to larger radius of its splats, from its principal curvatures
    stp_vec3
        stretch; ///< long axis of its splats: the direction of the smaller curvature; a unit vector if `ratio` is below 1
    bool known;  ///< it has enough points to fit a plane
    bool edge;   ///< it may contain an edge
} stp_leaf_facts;

/// Computes plane, flatness, area and edge of each leaf. Leaves with few points are marked unknown. Uses all threads.
/// @param scatters NULL, or receives the scatter of each leaf's sample, relative to the leaf's corner
void stp_leaf_facts_of_places(stp_context* context, const stp_leaf_octree* octree,
                              const stp_leaf_points* points, stp_leaf_facts* facts,
                              stp_scatter* scatters);

/// Median spacing of all points. 0 without leaves.
float stp_leaf_median_spacing(const stp_leaf_octree* octree, const stp_leaf_facts* facts);

/// Sets the representative normals from oriented normals; leaves them unchanged if signs are unknown. Uses all threads.
void stp_leaf_facts_of_normals(stp_context* context, const stp_leaf_octree* octree,
                               const stp_leaf_points* points, stp_leaf_facts* facts);

/// Computes spread and curvature. Normals are turned to the side of the leaf's normal, so their signs do not matter. Uses all
/// threads.
void stp_leaf_facts_of_bends(stp_context* context, const stp_leaf_octree* octree,
                             const stp_leaf_points* points, stp_leaf_facts* facts);
