// SPDX-License-Identifier: MIT
// Cuts large meshes and point sets by planes into pieces of bounded size.
#pragma once

#include "scene/scene.h"

/// Splits a mesh of more than `maximum` triangles into as few pieces as possible, of about equal
/// size, and appends them to the scene. Each triangle goes whole to the piece that contains its
/// centroid. Pieces keep name, material, attributes and grid step; have bounds, area and content;
/// and lie in the spill if the mesh does or memory is short. The mesh itself stays.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (logged; no piece was added)
STP_MUST_USE stp_result stp_cut_mesh(stp_scene* scene, uint32_t mesh, uint32_t maximum,
                                     uint32_t* first_piece, uint32_t* piece_count);

/// Splits a point set likewise.
STP_MUST_USE stp_result stp_cut_points(stp_scene* scene, uint32_t set, uint32_t maximum,
                                       uint32_t* first_piece, uint32_t* piece_count);
