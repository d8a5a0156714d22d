// SPDX-License-Identifier: MIT
// Pictures to and from PNG files (libspng).
#pragma once

#include "base/context.h"

#include <stipple/image.h>

/// Writes aside and renames.
STP_MUST_USE stp_result stp_png_write(stp_context* context, const stp_image* image, const char* path);
/// The pixels come from stp_alloc.
STP_MUST_USE stp_result stp_png_read(stp_context* context, const char* path, stp_image* image);
