// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.h"

/// Encodes as PNG what came as something else, or was changed by import, wherever that is smaller than its texels.
/// Textures that came as PNG, JPEG or WebP stay as they are. All threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_build_encode_textures(stp_scene* scene);
