// SPDX-License-Identifier: MIT
// Large meshes and point sets cut by planes into pieces of bounded size.
#pragma once

#include "scene/scene.h"

/// Appends to the scene the pieces of a mesh that has more than `most` triangles: as few as there can be, all of
/// about the same size. Each triangle goes whole to the piece that its centroid lies in. Pieces keep name,
/// material, attributes and grid step, have bounds, area and content, and lie in the spill where the mesh does or
/// memory is short. The mesh itself stays. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO,
/// STP_ERROR_LIMIT (logged; no piece was added)
STP_MUST_USE stp_result stp_cut_mesh(stp_scene* scene, uint32_t mesh, uint32_t most,
                                     uint32_t* first_piece, uint32_t* piece_count);

/// The same for the points of a point set.
STP_MUST_USE stp_result stp_cut_points(stp_scene* scene, uint32_t set, uint32_t most,
                                       uint32_t* first_piece, uint32_t* piece_count);
