// SPDX-License-Identifier: MIT
// Disks that represent nodes of a point tree, and the errors of a disk that replaces its children
// (Dachsbacher et al. 2003, sections 3.1 to 3.4).
#pragma once

#include "base/math/math.h"

enum { STP_DISK_CHILDREN = 8 }; ///< maximum children of an octree node

/// A disk in space. A normal of length 0 makes it a sphere: for points with unknown orientation.
typedef struct stp_tree_disk {
    stp_vec3 center;
    stp_vec3 normal; ///< unit length, or zero
    float radius;
} stp_tree_disk;

/// Errors of a disk that represents its children, in the units of their coordinates; never
/// negative.
typedef struct stp_disk_error {
    /// Distance between the two planes parallel to the disk that enclose all children (3.2)
    float perpendicular;
    /// Maximum excess width of the disk over its children, over all directions (3.3)
    float tangential;
    float geometric; ///< combined: maximum over all view directions (3.4)
} stp_disk_error;

/// Disk with the children's mean normal that encloses their projections along it; a sphere around
/// them if their normals cancel out. Along the normal, its centre is at the children's mean.
/// Usually at most one percent larger than the smallest such disk.
/// @param weights weight of each child in means; positive
stp_tree_disk stp_disk_enclose(const stp_tree_disk* children, const float* weights, uint32_t count);

/// Errors of a disk that represents its children. For a sphere all are its diameter.
stp_disk_error stp_disk_measure(const stp_tree_disk* disk, const stp_tree_disk* children,
                                uint32_t count);
