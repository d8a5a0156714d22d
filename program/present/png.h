// SPDX-License-Identifier: MIT
// Reads and writes PNG files (libspng).
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

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
