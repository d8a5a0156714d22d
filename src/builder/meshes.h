// SPDX-License-Identifier: MIT
// Codes the meshes of a scene as clusters. Each result is kept in the work folder.
#pragma once

#include "builder/draft.h"
#include "builder/stored_results.h"
#include "scene/scene.h"

typedef struct stp_build_meshes {
    stp_coded_mesh* coded; ///< one per mesh of the scene; bytes are in the work folder
    stp_hash* keys;        ///< one per mesh of the scene
    uint32_t made, found;  ///< meshes coded now; meshes that existed before the build
} stp_build_meshes;

/// `previous` and `draft` may be NULL. @return STP_OK, or the failure of a stage (logged)
STP_MUST_USE stp_result stp_build_meshes_make(const stp_scene* scene, stp_work* work,
                                              stp_previous_output* previous, stp_build_draft* draft,
                                              stp_build_meshes* meshes);
void stp_build_meshes_destroy(stp_context* context, stp_build_meshes* meshes);

/// Bit mask of the texture coordinate sets that a mesh's material reads; only these are stored. It
/// is part of a coded mesh's key, beside the mesh's content and grid step.
uint32_t stp_material_texcoords(const stp_material* material);

/// Codes one mesh; may run inside jobs. The caller owns `coded` (stp_coded_mesh_destroy). @return
/// as stp_clusters_encode
STP_MUST_USE stp_result stp_code_mesh(stp_context* context, const stp_mesh* mesh,
                                      uint32_t texcoords, stp_coded_mesh* coded);
