// SPDX-License-Identifier: MIT
// Several inputs may use the same view name; without this, only the first could be selected.
#pragma once

#include "scene/scene.h"

/// Appends a number to names that an earlier view has: front, front-2, front-3. Never takes a name
/// that an input used. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_distinguish_views(stp_scene* scene);
