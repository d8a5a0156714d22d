// SPDX-License-Identifier: MIT
// Accuracy of the points in sets (section 41 of docs/format.md).
#pragma once

#include "builder/method_sets.h"
#include "builder/writer_input.h"

/// Stores in the sets of all methods whether the signs of their normals are known, and the position
/// error of the points they hold, in scene units. `content` is made from the scene and these sets.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_note_certainty(const stp_scene* scene,
                                                 const stp_store_content* content,
                                                 stp_build_methods* methods);

/// Stores in the sets of a method that finds no signs, before all are made, whether those of their
/// normals are known.
/// @param set_of_node STP_NONE: the node has no set
/// @param context for memory. @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_note_signs(stp_context* context, const stp_scene* scene,
                                             const uint32_t* set_of_node, stp_splats* sets);
