// SPDX-License-Identifier: MIT
// Several inputs may name a view alike: then only the first could be asked for.
#pragma once

#include "scene/scene.h"

/// Appends a number to each name that an earlier view has: front, front-2, front-3. No name that a view came with is
/// taken by another. @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_scene_distinguish_views(stp_scene* scene);
