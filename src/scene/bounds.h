// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.h"

/// Replaces the root's bounds by the tight box of all placed vertices, unless there are too many.
/// The scene must have a root. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_tighten_root(stp_scene* scene);
