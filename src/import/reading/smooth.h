// SPDX-License-Identifier: MIT
//
// Normals for meshes that come without: smooth across edges where surfaces turn little, sharp at
// the others. For CAD exports whose curved faces would look like their facets.
#pragma once

#include "import/reading/import.h"

/// Adds a mesh of the file that is being read; takes over its arrays, like stp_scene_add_mesh. With
/// desc.smooth_degrees above 0, a mesh without normals gets some.
/// @return STP_OK, or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_import_add_mesh(stp_import* import, stp_mesh* mesh, uint32_t* index);

/// Gives a mesh normals: at each corner the mean of the faces around its position whose normals are
/// at most `degrees` from that of its own face, weighted by their angles there (Thürmer and
/// Wüthrich: Computing Vertex Normals from Polygonal Facets. 1998). Vertices at one position count
/// as one; those that need several normals are repeated. Positions of more than 4,096 corners stay
/// sharp, and so do meshes of more than 2^32 corners. Deterministic.
/// @param degrees 0 to 180
/// @return STP_OK; STP_ERROR_OUT_OF_MEMORY (logged), the mesh is unchanged
STP_MUST_USE stp_result stp_smooth_mesh(stp_context* context, double degrees, stp_mesh* mesh);
