// SPDX-License-Identifier: MIT
// Converts a finished scene to the input of the writer.
#pragma once

#include "scene/scene.h"
#include "store/writer/writer.h"

/// Input of the writer, and arrays that it needs in addition to the scene's.
typedef struct stp_build_content {
    stp_store_content content;
    stp_context* context;
    stp_arena arena;
} stp_build_content;

/// Converts the scene, which must outlive the content. `sets` are the splat sets. `set_of_node`
/// gives the set of each node, or STP_NONE (NULL: no node has one). The caller adds shadings and
/// parameters. @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_LIMIT (logged; nothing to
/// destroy)
STP_MUST_USE stp_result stp_build_content_create(const stp_scene* scene, const stp_splats* sets,
                                                 uint32_t set_count, const uint32_t* set_of_node,
                                                 stp_build_content* content);
void stp_build_content_destroy(stp_build_content* content);
