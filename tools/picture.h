// SPDX-License-Identifier: MIT
// Pictures from and to the command line: PNG files, and "-" for stdin and stdout.
#pragma once

#include "command.h"

#include <stipple/image.h>

/// The pixels come from stp_alloc. Failures are logged by the context.
STP_MUST_USE stp_result tool_read_picture(stp_context* context, const char* path, stp_image* image);
STP_MUST_USE stp_result tool_write_picture(stp_context* context, const stp_image* image,
                                           const char* path);
