// SPDX-License-Identifier: MIT
// Pictures from and to the command line: files, and "-" for stdin and stdout. Reads PNG; writes the
// format that the name asks for (program/present/picture_file.h).
#pragma once

#include "program/options/command.h"

#include <stipple/image.h>

/// Rejects an output suffix that is not a writable picture format. NULL and "-" pass. @return 0, or
/// 2 (message printed)
int tool_check_picture(const char* path);

/// The pixels come from stp_alloc. Failures are logged by the context.
STP_MUST_USE stp_result tool_read_picture(stp_context* context, const char* path, stp_image* image);
STP_MUST_USE stp_result tool_write_picture(stp_context* context, const stp_image* image,
                                           const char* path);
