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
} stp_build_content;

/// Converts the scene, which must outlive the content. `sets` are what nodes look like from outside; `set_of_node`
/// gives the set of each node, or STP_NONE (NULL: no node has one). Shadings and parameters are the caller's to
/// add.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing is left to destroy)
STP_MUST_USE stp_result stp_build_content_create(const stp_scene* scene, const stp_splats* sets,
                                                 uint32_t set_count, const uint32_t* set_of_node,
                                                 stp_build_content* content);
void stp_build_content_destroy(stp_build_content* content);
