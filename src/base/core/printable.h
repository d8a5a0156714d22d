// SPDX-License-Identifier: MIT
// Untrusted text (file names, names in files): escaped for a terminal, and truncated.
#pragma once

#include <stddef.h>
#include <stdint.h>

/// Copies UTF-8 text. Escapes as \xNN per byte: control characters (including line ends and tabs),
/// bidirectional controls and line separators (U+061C, U+200E, U+200F, U+2028 to U+202E, U+2066 to
/// U+2069), and invalid UTF-8. Truncates to `size` bytes including the final zero; characters and
/// escapes stay whole.
/// @return the length of `out`
size_t stp_make_printable(const char* text, char* out, size_t size);

/// Finds the first character from U+007F on that stp_make_printable() escapes, which are those that
/// JSON allows unescaped.
/// @return its offset, and its bytes in `*length`; `size` if there is none
size_t stp_find_unprintable(const char* text, size_t size, uint32_t* code, size_t* length);

/// Length of a text truncated at `length` bytes, without a partial UTF-8 character at the end.
size_t stp_utf8_whole(const char* text, size_t length);
