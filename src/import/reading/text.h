// SPDX-License-Identifier: MIT
//
// Scanning of text formats. All pointers refer to text that ends with a line end ('\n'), so
// scanning needs no second bound: no function reads past the first '\n'.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef const unsigned char* stp_text;

static inline bool stp_is_blank(unsigned char c)
{
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
}

static inline bool stp_is_digit(unsigned char c)
{
    return c >= '0' && c <= '9';
}

static inline stp_text stp_skip_blanks(stp_text at)
{
    while (stp_is_blank(*at)) {
        ++at;
    }
    return at;
}

/// The end of the word that starts here.
static inline stp_text stp_skip_word(stp_text at)
{
    while (!stp_is_blank(*at) && *at != '\n') {
        ++at;
    }
    return at;
}

/// Whether the word [at, end) is `word`, ignoring case; `word` is in lower case.
bool stp_word_is(stp_text at, stp_text end, const char* word);

/// Reads a decimal number (after blanks) as C writes it; "nan" and "inf" in their usual spellings,
/// too.
/// @return the text after it, or NULL if it is not a number
///
/// Numbers of up to 15 significant digits whose power of ten is within 22 (nearly all that programs
/// write for coordinates) come out as the nearest double; others within two units in the last place.
/// Only basic arithmetic: the same bits on every machine, in every locale.
stp_text stp_read_number(stp_text at, double* value);

/// Reads a whole number (after blanks); values beyond about 9.2e18 become +-INT64_MAX / 10.
/// @return the text after it, or NULL if it is not a number
stp_text stp_read_integer(stp_text at, int64_t* value);

/// Bytes of the byte order mark of UTF-8 with which a text begins; 0: it has none, or is binary.
size_t stp_text_mark(stp_text bytes, size_t size);

/// In a text without line feeds, makes carriage returns the ends of lines (classic Mac OS).
void stp_text_end_lines(unsigned char* bytes, size_t size);

/// Splits bytes into whole lines, used in place, and an unfinished last line, which the caller
/// copies. @return the number of bytes in whole lines
size_t stp_whole_lines(stp_text bytes, size_t size);

/// Line number, from 1, of the line that contains `offset`.
uint64_t stp_line_number(stp_text bytes, size_t offset);
