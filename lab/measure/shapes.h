// SPDX-License-Identifier: MIT
//
// Distances from points to the shapes of an approximation: elliptical disks and triangles.
#pragma once

#include "base/math/math.h"

#include <stddef.h>

/// An elliptical disk: centre + s * larger + t * smaller, where s s + t t <= 1. The axes are
/// perpendicular. Either may be zero: then the disk is a segment, or a point.
typedef struct stp_disk_shape {
    stp_vec3 center;
    stp_vec3 larger;  ///< semi-axis with its length
    stp_vec3 smaller; ///< likewise; not longer than `larger`
} stp_disk_shape;

/// Disks and triangles. The caller owns the arrays, which are only read. All numbers are finite.
typedef struct stp_shapes {
    const stp_disk_shape* disks;
    size_t disk_count;
    const float* positions;  ///< 3 per vertex
    const uint32_t* indices; ///< 3 per triangle, each below the number of vertices
    size_t triangle_count;
} stp_shapes;

/// Squared distance from a point to the nearest place of a disk, including its interior. Outside,
/// the nearest place of the boundary is a root of a convex function (Eberly, Distance from a Point
/// to an Ellipse, 2013); Newton's method approaches it from one side. Exact up to rounding, for any
/// ratio of the axes.
/// @param maximum a larger result need not be exact, only larger than this; infinity: always exact
double stp_disk_distance_squared(const stp_disk_shape* disk, stp_vec3d point, double maximum);

/// Squared distance from a point to the nearest place of a triangle, which may be degenerate
/// (Ericson, Real-Time Collision Detection, 2005, 5.1.5).
double stp_triangle_distance_squared(const stp_vec3d corners[3], stp_vec3d point);

/// Pi times the product of the semi-axes.
double stp_disk_area(const stp_disk_shape* disk);
double stp_triangle_area(const stp_vec3d corners[3]);

/// The corners of triangle `index` of an index array.
void stp_triangle_corners(const float* positions, const uint32_t* indices, size_t index,
                          stp_vec3d corners[3]);
