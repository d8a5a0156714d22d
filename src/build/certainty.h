// SPDX-License-Identifier: MIT
// How certain sets are of what they have of points (section 41 of docs/format.md).
#pragma once

#include "build/content.h"
#include "build/methods.h"

/// Notes in the sets of all methods whether the signs of their normals are known, and how far the points that they hold may lie
/// from where the scene has them. `content` is made of the scene and these sets.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_build_note_certainty(const stp_scene* scene,
                                                 const stp_store_content* content,
                                                 stp_build_methods* methods);
