// SPDX-License-Identifier: MIT
// Escapes untrusted text (names in files, file names) for display on a terminal.
#pragma once

#include <stddef.h>

/// Copies UTF-8 text. Control characters (line ends and tabs, too), characters that turn or separate lines
/// (U+200E, U+200F, U+2028 to U+202E, U+2066 to U+2069), and bytes that are no UTF-8 become \xNN, a byte each. What does
/// not fit into `size` bytes with the zero at the end is left out; characters and escapes stay whole.
/// @return the length of `out`
size_t stp_make_printable(const char* text, char* out, size_t size);
