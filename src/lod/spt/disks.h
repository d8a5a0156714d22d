// SPDX-License-Identifier: MIT
// Disks: what stands for a node of a point tree and for its children, and how much the one differs
// from the others (Dachsbacher et al. 2003, 3.1 to 3.4).
#pragma once

#include "base/math.h"

enum { STP_DISK_CHILDREN = 8 }; ///< of a node of an octree, at most

/// A disk in space. A normal of length 0 makes it a sphere: points of which nobody knows where they
/// face.
typedef struct stp_disk {
    stp_vec3 center;
    stp_vec3 normal; ///< of unit length, or zero
    float radius;
} stp_disk;

/// How far disks that stand for others are from them, in the units of space; none is negative.
typedef struct stp_disk_error {
    /// distance of the planes parallel to the disk that enclose all children (3.2)
    float perpendicular;
    /// by how much the disk is wider than its children in the direction where that is most (3.3)
    float tangential;
    float geometric; ///< of both: the most that any direction of view sees (3.4)
} stp_disk_error;

/// The disk of the children's mean normal that encloses them, seen along that normal; a sphere
/// around them where they have no mean normal. Along the normal it lies at their mean. Larger than
/// the smallest such disk by no more than a hundredth, mostly.
/// @param weights how much each child counts in means; positive
/// @param count 1 to STP_DISK_CHILDREN
stp_disk stp_disk_enclose(const stp_disk* children, const float* weights, uint32_t count);

/// The errors of a disk that stands for its children. Of a sphere all are its diameter.
stp_disk_error stp_disk_measure(const stp_disk* disk, const stp_disk* children, uint32_t count);
