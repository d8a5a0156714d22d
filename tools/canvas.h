// SPDX-License-Identifier: MIT
// An opaque picture that is drawn on: fields, lines, other pictures and text.
#pragma once

#include "base/context.h"

#include <stipple/image.h>

typedef struct canvas_color {
    uint8_t rgb[3];
} canvas_color;

typedef struct canvas {
    stp_context* context;
    stp_image image; ///< opaque
    struct canvas_font* font;
} canvas;

enum { CANVAS_SIDE_MOST = 32768 };

/// White. Text needs a font of the system (DejaVu, Noto or Liberation Sans); without one none is drawn, with a warning.
/// @return STP_OK, STP_ERROR_LIMIT, STP_ERROR_OUT_OF_MEMORY; logged
STP_MUST_USE stp_result canvas_create(stp_context* context, uint32_t width, uint32_t height,
                                      canvas* c);
void canvas_destroy(canvas* c);

/// Places may lie outside; what does is left out.
void canvas_fill(canvas* c, int x, int y, int width, int height, canvas_color color);

/// A line of `thickness` pixels, antialiased; places are of pixels' centres.
void canvas_line(canvas* c, const double from[2], const double to[2], double thickness,
                 canvas_color color);

/// A picture on white, its upper left corner there, in its own size.
void canvas_put(canvas* c, int x, int y, const stp_image* picture);

/// UTF-8, one line; `y` is its baseline. @return how far it reaches
int canvas_text(canvas* c, int x, int y, double size, canvas_color color, const char* text);
int canvas_text_width(const canvas* c, double size, const char* text);

/// A copy that fits into the width and height: a larger picture becomes smaller, each pixel the mean of those it stands for; one
/// less than half as large is enlarged by a whole factor. Pixels from stp_alloc. @return STP_OK,
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result canvas_fit(stp_context* context, const stp_image* picture, uint32_t width,
                                   uint32_t height, stp_image* fitted);
