// SPDX-License-Identifier: MIT
// Pictures of older programs, which OBJ, 3DS, DAE and FBX files name: TGA and BMP.
#pragma once

#include "scene/scene.h"

/// Decodes TGA (1, 3 and 9 to 11: mapped, true colour and grey, plain or run-length) or BMP (8, 24
/// and 32 bits, not compressed) to RGBA. Fills width, height and texels of `texture`. Logs nothing;
/// `*reason` says why not.
/// @return STP_OK, STP_ERROR_UNSUPPORTED, STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes,
                                               size_t size, stp_texture* texture,
                                               const char** reason);
