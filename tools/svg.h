// SPDX-License-Identifier: MIT
// Drawings as SVG files. The first failure stays, and is returned at the end.
#pragma once

#include "command.h"

#include "base/file.h"

typedef struct svg {
    stp_file_writer* writer;
    stp_result result;
} svg;

/// Whether a file can be written there, which is better known before what is to be drawn is measured. Failures are logged.
STP_MUST_USE stp_result svg_check(stp_context* context, const char* path);
/// Begins a file on white ground. Failures are logged.
STP_MUST_USE stp_result svg_open(stp_context* context, const char* path, double width,
                                 double height, svg* s);
/// Up to 511 characters.
void svg_put(svg* s, const char* format, ...) __attribute__((format(printf, 2, 3)));
/// Text from outside: file names may hold anything.
void svg_put_text(svg* s, const char* text);
/// Ends the file: it is there, or it is not.
STP_MUST_USE stp_result svg_close(svg* s);
