// SPDX-License-Identifier: MIT
// Writes pictures in the format that the file name implies: PNG, JPEG or WebP.
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

typedef enum stp_picture_format {
    STP_PICTURE_PNG,  ///< lossless, with transparency
    STP_PICTURE_JPEG, ///< quality 92, full chroma; transparent pixels become white
    STP_PICTURE_WEBP, ///< lossless, with transparency
    STP_PICTURE_UNKNOWN,
} stp_picture_format;

/// Format of the path's suffix, case-insensitive; PNG without a suffix.
stp_picture_format stp_picture_format_of(const char* path);

/// Writes to a temporary file and renames it. The same bytes for the same picture and library
/// versions.
/// @return STP_OK; STP_ERROR_UNSUPPORTED for an unknown suffix; STP_ERROR_LIMIT for more pixels per
/// side than the format allows; STP_ERROR_IO; STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_picture_write(stp_context* context, const stp_image* image,
                                          const char* path);

/// End of the message about an unknown suffix.
#define STP_PICTURE_SUFFIXES ".png, .jpg, .jpeg or .webp"
