// SPDX-License-Identifier: MIT
//
// Letters beyond those that the font of the panels always has: a font of all scripts has tens of thousands, of which a
// file's names need some. What texts need is noted here as they are shown, and the font is made anew with it.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { GLYPHS_MOST = 4096 };

typedef struct glyph_set {
    uint16_t points[GLYPHS_MOST]; ///< ascending
    size_t count;
    uint16_t ranges[2 * GLYPHS_MOST + 1]; ///< of glyphs_make_ranges
} glyph_set;

/// Pairs of first and last code point that are always there, and a zero.
extern const uint16_t glyphs_always[];

/// Notes what a text needs. UTF-8; what is none, and what lies beyond the basic plane, is passed over.
/// @return whether anything is new
bool glyphs_note(glyph_set* set, const char* text);
/// What is noted, as pairs of first and last code point, and a zero.
const uint16_t* glyphs_make_ranges(glyph_set* set);
