// SPDX-License-Identifier: MIT
// Pictures from memory: PNG (libspng), JPEG (libjpeg-turbo), WebP (libwebp), told apart by content.
#pragma once

#include "scene/scene.h"

/// Decodes to RGBA. Fills width, height and texels (stp_alloc) of `texture`; other fields are left alone.
/// Pictures of more than 2^28 pixels are refused. `name` begins the message of a failure.
STP_MUST_USE stp_result stp_image_decode(stp_context* context, const char* name,
                                         const unsigned char* bytes, size_t size, stp_texture* texture);
