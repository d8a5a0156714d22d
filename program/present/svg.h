// SPDX-License-Identifier: MIT
// Drawings as SVG files. The first error is kept and returned at the end.
#pragma once

#include "base/io/file.h"
#include "program/options/command.h"

typedef struct svg {
    stp_file_writer* writer;
    stp_result result;
} svg;

/// Whether the file can be written, checked before the measurements. Failures are logged.
STP_MUST_USE stp_result svg_check(stp_context* context, const char* path);
/// Begins a file with a white background. Failures are logged.
STP_MUST_USE stp_result svg_open(stp_context* context, const char* path, double width,
                                 double height, svg* s);
/// Up to 511 characters.
void svg_put(svg* s, const char* format, ...) __attribute__((format(printf, 2, 3)));
/// Escapes text from outside: file names may hold anything.
void svg_put_text(svg* s, const char* text);
/// Completes the file, or leaves none.
STP_MUST_USE stp_result svg_close(svg* s);
