// SPDX-License-Identifier: MIT
// Untrusted text (names in files, file names): escaped for display on a terminal, and shortened.
#pragma once

#include <stddef.h>
#include <stdint.h>

/// Copies UTF-8 text. Control characters (line ends and tabs, too), characters that turn or separate lines
/// (U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069), and bytes that are no UTF-8 become \xNN, a byte each. What does
/// not fit into `size` bytes with the zero at the end is left out; characters and escapes stay whole.
/// @return the length of `out`
size_t stp_make_printable(const char* text, char* out, size_t size);

/// Finds the first character from U+007F on that stp_make_printable() escapes: those that JSON may leave as they are.
/// @return where it begins, and its bytes in `*length`; `size`: there is none
size_t stp_find_unprintable(const char* text, size_t size, uint32_t* code, size_t* length);

/// Bytes of the first `length` bytes of a text without what a cut there leaves of a character of UTF-8.
size_t stp_utf8_whole(const char* text, size_t length);
