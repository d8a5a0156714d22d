// SPDX-License-Identifier: MIT
//
// What the files of the tool itself share; commands need only command.h.
#pragma once

#include "command.h"

#include <stdio.h>

/// What the options common to all commands say.
typedef struct tool_settings {
    bool help, version, quiet, verbose;
    const char* command; ///< the command that runs; NULL: none yet
    const char* columns; ///< stp_import_desc.columns of models that are imported; NULL: not said
} tool_settings;

tool_settings* tool_settings_get(void);

/// The command of that name, or NULL.
const command* tool_find_command(const char* name);

/// Whether escape sequences belong on this stream: a terminal, and neither NO_COLOR nor TERM=dumb.
bool tool_has_color(FILE* stream);

/// Whether both exist and are one file, by whatever names.
bool tool_is_same_file(const char* a, const char* b);

/// After a command that ended with `code`: where an interrupt stopped it, says so and `results` (command.interrupted).
/// @return 130, or `code` where it was not interrupted or ended well all the same
int tool_finish_interrupted(int code, const char* results);

/// Takes the progress bar off the terminal, before anything else is printed there.
void tool_end_progress(void);

/// Ends stdout's buffer. @return `code`, or 1 where writing failed (message printed)
int tool_finish_output(int code);

/// `stipple help` and `stipple help NAME`.
void help_print_overview(FILE* stream);
void help_print_command(FILE* stream, const command* c);

/// The man page of a command, or of the whole tool (NULL), as mdoc(7).
void manual_print(FILE* stream, const command* c);

/// Shell completions for "bash", "zsh" or "fish".
void completion_print_bash(FILE* stream);
void completion_print_zsh(FILE* stream);
void completion_print_fish(FILE* stream);
