// SPDX-License-Identifier: MIT
// Identity by content: what things are, whatever their names and indices.
#pragma once

#include "scene/scene.h"

/// Of the geometry alone, without the material.
stp_hash stp_mesh_hash(const stp_mesh* mesh);
stp_hash stp_points_hash(const stp_point_set* points);
stp_hash stp_texture_hash(const stp_texture* texture);
/// Of everything that is seen of it. Its textures have their hashes.
stp_hash stp_material_hash(const stp_scene* scene, const stp_material* material);
/// Of everything below. Parts, materials and children have their hashes.
stp_hash stp_node_hash(const stp_scene* scene, const stp_node* node);
