// SPDX-License-Identifier: MIT
//
// GNU command lines from tables: --name VALUE, --name=VALUE, -n VALUE, -nVALUE, flags together
// (-qv), options and arguments in any order, only arguments after --, the last of repeated options
// counts. An option with an optional value takes the next word only if it is a number, or its word
// for 0.

#include "program/options/command.h"

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
