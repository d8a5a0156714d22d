// SPDX-License-Identifier: MIT
// An opaque picture to draw on: rectangles, lines, pictures and text.
#pragma once

#include "base/core/context.h"

#include <stipple/image.h>

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
