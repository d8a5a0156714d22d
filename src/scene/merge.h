// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.h"

/// Merges identical textures, then identical materials, then meshes and point sets: drops copies,
/// redirects references to the first of its kind, and sets all content hashes.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged; the scene stays valid)
STP_MUST_USE stp_result stp_scene_merge(stp_scene* scene);
