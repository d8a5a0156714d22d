// SPDX-License-Identifier: MIT
// Pictures from memory: PNG (libspng), JPEG (libjpeg-turbo), WebP (libwebp), told apart by content.
#pragma once

#include "scene/scene.h"

/// Decodes to RGBA. Fills width, height and texels (stp_alloc) of `texture`; other fields are left
/// alone. Pictures of more than 2^28 pixels are refused. `name` begins the message of a failure.
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_UNSUPPORTED, STP_ERROR_LIMIT,
/// STP_ERROR_OUT_OF_MEMORY
STP_MUST_USE stp_result stp_image_decode(stp_context* context, const char* name,
                                         const unsigned char* bytes, size_t size,
                                         stp_texture* texture);

typedef enum stp_image_kind {
    STP_IMAGE_UNKNOWN,
    STP_IMAGE_PNG,
    STP_IMAGE_JPEG,
    STP_IMAGE_WEBP,
    STP_IMAGE_KTX2, ///< recognised, not decoded
} stp_image_kind;

enum { STP_IMAGE_REASON_SIZE = 160 };

/// What a picture's header says, and the sentence why it cannot be decoded.
typedef struct stp_image_info {
    stp_image_kind kind;
    uint32_t width, height;
    char reason[STP_IMAGE_REASON_SIZE]; ///< set where a call below fails
} stp_image_info;

/// Reads the header only. Logs nothing.
STP_MUST_USE stp_result stp_image_measure(const unsigned char* bytes, size_t size,
                                          stp_image_info* info);

/// Decodes what stp_image_measure accepted. Logs nothing, so jobs may call it; `info` has the
/// reason.
STP_MUST_USE stp_result stp_image_decode_measured(stp_context* context, const unsigned char* bytes,
                                                  size_t size, stp_image_info* info,
                                                  stp_texture* texture);
