// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.h"

/// Makes identical textures one, then identical materials, then meshes and point sets: copies are dropped, what
/// refers to them is turned to what stays (the first of its kind), and everything has its content's hash.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged; the scene is whole)
STP_MUST_USE stp_result stp_scene_merge(stp_scene* scene);
