// SPDX-License-Identifier: MIT
// Picture formats of older programs, used by OBJ, 3DS, DAE and FBX files: TGA and BMP.
#pragma once

#include "scene/scene.h"

/// Decodes TGA (types 1, 3 and 9 to 11: mapped, true colour and grey, plain or run-length) or BMP
/// (8, 24 and 32 bits, uncompressed) to RGBA. Fills width, height and texels of `texture`. Does not
/// log; on failure `*reason` explains why. @return STP_OK, STP_ERROR_UNSUPPORTED,
/// STP_ERROR_TRUNCATED, STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode_plain(stp_context* context, const unsigned char* bytes,
                                               size_t size, stp_texture* texture,
                                               const char** reason);
