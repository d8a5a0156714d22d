// SPDX-License-Identifier: MIT
// Pictures from and to the command line: files, and "-" for stdin and stdout. Read are PNG files, written what the name
// says (present/picture_file.h).
#pragma once

#include "command.h"

#include <stipple/image.h>

/// Refuses an output whose suffix is no picture's that can be written. NULL and "-" pass. @return 0, or 2 (message printed)
int tool_check_picture(const char* path);

/// The pixels come from stp_alloc. Failures are logged by the context.
STP_MUST_USE stp_result tool_read_picture(stp_context* context, const char* path, stp_image* image);
STP_MUST_USE stp_result tool_write_picture(stp_context* context, const stp_image* image,
                                           const char* path);
