// SPDX-License-Identifier: MIT
// Bounds, counts and areas.
#pragma once

#include "scene/scene.h"

/// Bounds and area of a mesh's triangles. Unused vertices do not count: many meshes of one file may
/// share a vertex array.
void stp_mesh_measure(stp_mesh* mesh);

/// Sets bounds, counts and area of a node from those of its parts and children.
void stp_node_measure(const stp_scene* scene, stp_node* node);
