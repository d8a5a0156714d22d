// SPDX-License-Identifier: MIT
//
// Drops geometry that is too far away or has no valid position. Squared lengths are floats in many
// places, and one very distant object would shrink everything else to a point. Each time, as little
// as possible is dropped: triangles of a mesh, points of a set, else an object within its parent.
#pragma once

#include "scene/scene.h"

// Maximum distance from the origin along each axis: squares stay below FLT_MAX.
#define STP_SCENE_DISTANCE_LIMIT 1e18

/// Whether a whole box is within the limit. False if it is empty or not finite.
bool stp_is_within_distance_limit(stp_boxd box);

/// Drops triangles with a corner beyond the limit and moves such vertices to the origin.
/// @return number of dropped triangles
uint32_t stp_mesh_drop_distant(stp_mesh* mesh);
/// Computes the bounds of a point set, after dropping points beyond the limit. @return number of
/// dropped points
uint32_t stp_point_set_measure(stp_point_set* points);

/// Warns once, naming the first object, if parts of meshes or point sets were dropped when they
/// were added (scene->damaged). Call before identical items are merged.
void stp_scene_report_dropped(const stp_scene* scene);
