// SPDX-License-Identifier: MIT
// A finished scene as the writer wants it.
#pragma once

#include "scene/scene.h"
#include "store/writer.h"

/// What the writer is given, and the arrays it points to beside the scene's own.
typedef struct stp_build_content {
    stp_store_content content;
    stp_context* context;
    stp_arena arena;
    stp_coded_mesh* coded; ///< one a mesh, once stp_code_meshes has been called
} stp_build_content;

/// Converts the scene, which must outlive the content. `surfels` (may be NULL) becomes what the root looks like
/// from outside. Shadings and parameters are the caller's to add.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing is left to destroy)
STP_MUST_USE stp_result stp_build_content_create(const stp_scene* scene, const stp_surfels* surfels,
                                                 stp_build_content* content);
void stp_build_content_destroy(stp_build_content* content);
