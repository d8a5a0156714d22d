// SPDX-License-Identifier: MIT
// Meshes of a scene coded to clusters.
#pragma once

#include "build/content.h"

/// Which of a mesh's two sets of texture coordinates its material reads (bit 0, bit 1): the others are not
/// stored. Part of what a coded mesh was made from, beside the mesh's content and its grid step.
uint32_t stp_material_texcoords(const stp_material* material);

/// Codes one mesh; may run inside jobs. `coded` is the caller's (stp_coded_mesh_destroy).
/// @return as stp_clusters_encode
STP_MUST_USE stp_result stp_code_mesh(stp_context* context, const stp_mesh* mesh,
                                      uint32_t texcoords, stp_coded_mesh* coded);

/// Codes all meshes of the scene that the content was made from, in parallel.
STP_MUST_USE stp_result stp_code_meshes(const stp_scene* scene, stp_build_content* content);
