// SPDX-License-Identifier: MIT
// Content hashes: identify data independently of names and indices.
#pragma once

#include "scene/scene.h"

/// Hash of the geometry, without the material.
stp_hash stp_mesh_hash(const stp_mesh* mesh);
stp_hash stp_points_hash(const stp_point_set* points);
stp_hash stp_texture_hash(const stp_texture* texture);
/// Hash of all visible properties. The textures must have their hashes.
stp_hash stp_material_hash(const stp_scene* scene, const stp_material* material);
/// Hash of everything below. Parts, materials and children must have their hashes.
stp_hash stp_node_hash(const stp_scene* scene, const stp_node* node);
