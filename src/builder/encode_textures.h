// SPDX-License-Identifier: MIT
#pragma once

#include "scene/scene.h"

/// Encodes textures as PNG if they came in another format or import changed them, and if PNG is
/// smaller than the texels. Textures that came as PNG, JPEG or WebP stay as they are. All threads.
/// @return STP_OK, STP_ERROR_OUT_OF_MEMORY, STP_ERROR_IO (logged)
STP_MUST_USE stp_result stp_build_encode_textures(stp_scene* scene);
