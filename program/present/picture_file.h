// SPDX-License-Identifier: MIT
// Pictures as files: PNG, JPEG or WebP, as the name implies, and "-" for stdin and stdout.
#pragma once

#include "base/core/context.h"
#include "program/options/command.h"

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

// Pictures from and to the command line: files, and "-" for stdin and stdout. Reads PNG, JPEG and
// WebP, by their content; writes the format that the name implies.

/// Rejects an output suffix that is not a writable picture format. NULL and "-" pass. @return 0, or
/// 2 (message printed)
int tool_check_picture(const char* path);

/// The pixels come from stp_alloc. Failures are logged by the context.
STP_MUST_USE stp_result tool_read_picture(stp_context* context, const char* path, stp_image* image);
STP_MUST_USE stp_result tool_write_picture(stp_context* context, const stp_image* image,
                                           const char* path);

// Reads and writes PNG files (libspng).

/// Writes to a temporary file and renames it. The same bytes for the same picture.
STP_MUST_USE stp_result stp_png_write(stp_context* context, const stp_image* image,
                                      const char* path);
/// Reads any PNG as 8-bit RGBA. The pixels come from stp_alloc.
STP_MUST_USE stp_result stp_png_read(stp_context* context, const char* path, stp_image* image);

/// Encodes to memory. `name` begins the error message; the caller frees the bytes (stp_free).
STP_MUST_USE stp_result stp_png_encode(stp_context* context, const stp_image* image,
                                       const char* name, unsigned char** bytes, size_t* size);
/// @return STP_OK, STP_ERROR_FORMAT, STP_ERROR_LIMIT (more than 2^28 pixels),
/// STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result stp_png_decode(stp_context* context, const char* name,
                                       const unsigned char* bytes, size_t size, stp_image* image);
