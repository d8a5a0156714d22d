// SPDX-License-Identifier: MIT
// Bounds, counts and areas.
#pragma once

#include "scene/scene.h"

/// The box and the area of a mesh's triangles. Vertices that no triangle uses do not count: many meshes of one
/// file may share an array of vertices.
void stp_mesh_measure(stp_mesh* mesh);

/// Fills bounds, counts and area of a node whose children have theirs.
void stp_node_measure(const stp_scene* scene, stp_node* node);
