// SPDX-License-Identifier: MIT
//
// What is too far away, or nowhere. Squares of lengths are floats in many places, and one object a universe away would
// make everything else a point. So what has no finite place, or one beyond the reach, is left out, each time as
// little as possible: triangles of a mesh, points of a set, else an object within its parent.
#pragma once

#include "scene/scene.h"

#define STP_SCENE_DISTANCE_LIMIT                                                                   \
    1e18 // from the origin, along each axis: squares stay far below FLT_MAX

/// Whether all of a box is within reach. Not where it is empty, or not finite.
bool stp_is_within_distance_limit(stp_boxd box);

/// Drops the triangles that have a corner out of reach; vertices out of reach are put to the origin. @return how many
uint32_t stp_mesh_drop_distant(stp_mesh* mesh);
/// Drops the points out of reach. @return how many
uint32_t stp_points_drop_distant(stp_point_set* points);

/// Says once, and naming the first object, of which meshes and point sets something was dropped when they were added
/// (scene->damaged). Before equal ones become one.
void stp_scene_tell_dropped(const stp_scene* scene);
