// SPDX-License-Identifier: MIT
// Pictures to files of the format that their name says: PNG, JPEG or WebP.
#pragma once

#include "base/context.h"

#include <stipple/image.h>

typedef enum stp_picture_format {
    STP_PICTURE_PNG,  ///< exact, with transparency
    STP_PICTURE_JPEG, ///< quality 92, full chroma; transparent pixels become white
    STP_PICTURE_WEBP, ///< lossless, with transparency
    STP_PICTURE_UNKNOWN,
} stp_picture_format;

/// By the path's suffix, whatever its case; without one it is PNG.
stp_picture_format stp_picture_format_of(const char* path);

/// Writes aside and renames. The same bytes for the same picture and version of the libraries.
/// @return STP_OK; STP_ERROR_UNSUPPORTED for a suffix that is not known; STP_ERROR_LIMIT for more pixels a side than
/// the format allows; STP_ERROR_IO; STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_picture_write(stp_context* context, const stp_image* image,
                                          const char* path);

/// The end of a message about a suffix that is not known.
#define STP_PICTURE_SUFFIXES ".png, .jpg, .jpeg or .webp"
