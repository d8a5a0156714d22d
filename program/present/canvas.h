// SPDX-License-Identifier: MIT
// Drawings: on an opaque picture, as an SVG file, and plots of frame times.
#pragma once

#include "base/core/context.h"
#include "base/io/file.h"
#include "program/options/command.h"

#include <stipple/image.h>

// An opaque picture to draw on: rectangles, lines, pictures and text.

typedef struct canvas_color {
    uint8_t rgb[3];
} canvas_color;

typedef struct canvas {
    stp_context* context;
    stp_image image; ///< opaque
    struct canvas_font* font;
} canvas;

enum { CANVAS_SIDE_MAX = 32768 };

/// Starts white. Text needs a system font (DejaVu, Noto or Liberation Sans); without one, text is
/// skipped with a warning. @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result canvas_create(stp_context* context, uint32_t width, uint32_t height,
                                      canvas* c);
void canvas_destroy(canvas* c);

/// Coordinates may lie outside; drawing is clipped.
void canvas_fill(canvas* c, int x, int y, int width, int height, canvas_color color);

/// A line of `thickness` pixels, antialiased; coordinates refer to pixel centres.
void canvas_line(canvas* c, const double from[2], const double to[2], double thickness,
                 canvas_color color);

/// Draws a picture at its own size, composited on white; x, y is its upper left corner.
void canvas_put(canvas* c, int x, int y, const stp_image* picture);

/// Draws one line of UTF-8; `y` is its baseline. @return the x at which it ends
int canvas_text(canvas* c, int x, int y, double size, canvas_color color, const char* text);
int canvas_text_width(const canvas* c, double size, const char* text);

/// A copy that fits into the width and height: a larger picture is reduced by averaging; one at
/// most half as large is enlarged by a whole factor. Pixels from stp_alloc. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result canvas_fit(stp_context* context, const stp_image* picture, uint32_t width,
                                   uint32_t height, stp_image* fitted);

// Drawings as SVG files. The first error is kept and returned at the end.

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

// Frame times of flights, as `stipple fly --json` reports them, plotted on a canvas.

enum { SHEET_FLIGHTS_MAX = 8 };

typedef struct sheet_flight {
    const char* path;
    const char* caption; ///< NULL: the path
    double *times, *frame_ms;
    size_t count;
    double budget_ms; ///< 0: none
} sheet_flight;

/// Reads `path`. Failures are logged by the context. Arrays are from stp_alloc.
STP_MUST_USE stp_result sheet_flight_read(stp_context* context, sheet_flight* flight);
void sheet_flight_destroy(stp_context* context, sheet_flight* flight);

/// Plots all flights over one axis of time, within a box. The other axis is logarithmic if frame
/// times differ by more than a factor of ten.
void sheet_plot(canvas* c, int x, int y, int width, int height, const sheet_flight* flights,
                size_t count);
