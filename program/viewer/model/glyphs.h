// SPDX-License-Identifier: MIT
//
// Additional glyphs: a font of all scripts has tens of thousands, but file names need only some.
// The code points of shown texts are collected here, and the font is rebuilt with them.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { GLYPHS_MAX = 4096 };

typedef struct glyph_set {
    uint16_t points[GLYPHS_MAX]; ///< ascending
    size_t count;
    uint16_t ranges[2 * GLYPHS_MAX + 1]; ///< written by glyphs_make_ranges
} glyph_set;

/// Pairs of first and last code point that are always available, ending with a zero.
extern const uint16_t glyphs_always[];

/// Adds the code points of a UTF-8 text. Skips invalid UTF-8 and code points outside the basic
/// plane. @return whether any is new
bool glyphs_note(glyph_set* set, const char* text);
/// The collected code points as pairs of first and last, ending with a zero.
const uint16_t* glyphs_make_ranges(glyph_set* set);
