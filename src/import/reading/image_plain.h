// SPDX-License-Identifier: MIT
// Picture formats of older programs, used by OBJ, 3DS, DAE and FBX files: TGA and BMP.
#pragma once

#include "scene/scene.h"

/// Decodes TGA (mapped, true colour and grey, plain or run-length) or BMP (1 to 32 bits,
/// uncompressed) to RGBA, with stb_image. Fills width, height and texels of `texture`. Does not log;
/// on failure `*reason` explains why. Memory is at most 450 times the size of the file.
/// @return STP_OK, STP_ERROR_UNSUPPORTED, STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes,
                                               size_t size, stp_texture* texture,
                                               const char** reason);
