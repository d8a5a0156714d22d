// SPDX-License-Identifier: MIT
// Steps of stp_scene_finish: they measure and hash content, drop what is too far away, and merge
// what is equal.
#pragma once

#include "scene/scene.h"

// Drops geometry that is too far away or has no valid position. Squared lengths are floats in many
// places, and one very distant object would shrink everything else to a point. Each time, as little
// as possible is dropped: triangles of a mesh, points of a set, else an object within its parent.

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

/// Merges identical textures, then identical materials, then meshes and point sets: drops copies,
/// redirects references to the first of its kind, and sets all content hashes.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged; the scene stays valid)
STP_MUST_USE stp_result stp_scene_merge(stp_scene* scene);

// Several inputs may use the same view name; without this, only the first could be selected.

/// Appends a number to names that an earlier view has: front, front-2, front-3. Never takes a name
/// that an input used. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_distinguish_views(stp_scene* scene);

/// Replaces the root's bounds by the tight box of all placed vertices, unless there are too many.
/// The scene must have a root. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_tighten_root(stp_scene* scene);

// Content hashes: identify data independently of names and indices.

/// Hash of the geometry, without the material.
stp_hash stp_mesh_hash(const stp_mesh* mesh);
stp_hash stp_points_hash(const stp_point_set* points);
stp_hash stp_texture_hash(const stp_texture* texture);
/// Hash of all visible properties. The textures must have their hashes.
stp_hash stp_material_hash(const stp_scene* scene, const stp_material* material);
/// Hash of everything below. Parts, materials and children must have their hashes.
stp_hash stp_node_hash(const stp_scene* scene, const stp_node* node);

// Bounds, counts and areas.

/// Bounds and area of a mesh's triangles. Unused vertices do not count: many meshes of one file may
/// share a vertex array.
void stp_mesh_measure(stp_mesh* mesh);

/// Counts the closed meshes of each front-only material that face inwards, and warns of them: from
/// outside, a part would vanish. After materials are merged.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_find_inverted(stp_scene* scene);

/// Sets bounds, counts and area of a node from those of its parts and children.
void stp_node_measure(const stp_scene* scene, stp_node* node);
