// SPDX-License-Identifier: MIT
// Codes the meshes of a scene as clusters, each result kept in the work directory.
#pragma once

#include "build/draft.h"
#include "build/previous_output.h"
#include "scene/scene.h"

typedef struct stp_build_meshes {
    stp_coded_mesh* coded; ///< one a mesh of the scene; bytes lie in the work directory
    stp_hash* keys;        ///< likewise
    uint32_t made, found;  ///< meshes made now; meshes that were there before the build began
} stp_build_meshes;

/// `former` and `draft` may be NULL. @return STP_OK, or what the stages return (logged)
STP_MUST_USE stp_result stp_build_meshes_make(const stp_scene* scene, stp_work* work,
                                              stp_previous_output* former, stp_build_draft* draft,
                                              stp_build_meshes* meshes);
void stp_build_meshes_destroy(stp_context* context, stp_build_meshes* meshes);

/// Which of a mesh's two sets of texture coordinates its material reads (bit 0, bit 1): the others are not
/// stored. Part of what a coded mesh was made from, beside the mesh's content and its grid step.
uint32_t stp_material_texcoords(const stp_material* material);

/// Codes one mesh; may run inside jobs. `coded` is the caller's (stp_coded_mesh_destroy).
/// @return as stp_clusters_encode
STP_MUST_USE stp_result stp_code_mesh(stp_context* context, const stp_mesh* mesh,
                                      uint32_t texcoords, stp_coded_mesh* coded);
