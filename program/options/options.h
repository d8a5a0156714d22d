// SPDX-License-Identifier: MIT
//
// GNU command lines from tables, messages that name options, and colours as option values.
#pragma once

#include "program/options/command.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Command lines: --name VALUE, --name=VALUE, -n VALUE, -nVALUE, flags together (-qv), options and
// arguments in any order, only arguments after --, the last of repeated options counts. An option
// with an optional value takes the next word only if it is a number, or its word for 0.

/// The options every command has; ends with a NULL name.
const option* options_common(void);

/// The command's options that the running program has, group by group, each with its heading; ends
/// with a NULL name. Valid until the next call.
const option* options_of(const command* c);

/// Reads the options of `table` (may be NULL) and the common ones from argv[0..*argc) and moves the
/// remaining arguments to the front. @return 0, or 2 (message printed)
int options_parse(const option* table, int* argc, char** argv);

/// Edit distance between two words: letters missing, added, swapped or wrong.
unsigned options_word_distance(const char* a, const char* b);

/// How help shows an option's value, such as "PX" or "blue|spt"; "" for flags.
const char* options_argument(const option* o);

/// The choices of an option whose argument does not show them; NULL: none.
const char* options_hidden_words(const option* o);
/// Reads `text` into the option's value. @return true; or false, with the reason in `problem` as
/// the end of a sentence that begins with the text
bool option_set_value(const option* o, const char* text, char* problem, size_t problem_size);

// Messages of the library name fields of its interface; users of the program know its options.

/// Copies a message, with each field's name replaced by that of the option which sets it. Cut to
/// `size` bytes.
void option_fields_name(const char* message, char* text, size_t size);

// CSS colour names and hexadecimal colours.

/// Reads a CSS colour name (ignoring case), or RRGGBB or RGB in hexadecimal, with or without "#".
/// @param color receives red, green and blue, sRGB
/// @return false if the text is not a colour
bool color_parse(const char* text, uint8_t color[3]);
