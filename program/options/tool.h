// SPDX-License-Identifier: MIT
//
// What the files of the tool share; commands only need command.h.
#pragma once

#include "program/options/command.h"

#include <stdio.h>

struct program;

/// The values of the common options.
typedef struct tool_settings {
    bool help, help_all, version, quiet, verbose;
    const struct program* program; ///< the one that runs; NULL before program_main
    const char* command;           ///< the command that runs; NULL: none yet
    char** arguments;              ///< those of the process, as they were given
    const char* columns;           ///< stp_import_desc.columns for imported models; NULL: not given
    double smooth_degrees;         ///< stp_import_desc.smooth_degrees for imported models
    char up;            ///< corrects the up axis of models (stp_import_desc.up); 0: not given
    double unit_metres; ///< corrects the unit of models; 0: not given
} tool_settings;

tool_settings* tool_settings_get(void);

/// The command of that name, or NULL.
const command* tool_find_command(const char* name);

/// Whether to use escape sequences on this stream: it is a terminal, NO_COLOR is not set, and TERM
/// is set to anything but dumb.
bool tool_has_color(FILE* stream);

/// Whether both paths exist and name the same file.
bool tool_is_same_file(const char* a, const char* b);

/// Finishes a command that ended with `code`: after an interrupt, prints so with `results`
/// (command.interrupted). @return 130, or `code` if the command was not interrupted or still
/// succeeded
int tool_finish_interrupted(int code, const char* results);

/// Removes the progress bar from the terminal before other output.
void tool_end_progress(void);

/// Flushes stdout. @return `code`, or 1 if writing failed (message printed)
int tool_finish_output(int code);

/// `stipple help` and `stipple help NAME`; `all`: with the options that are rarely needed.
void help_print_overview(FILE* stream);
void help_print_command(FILE* stream, const command* c, bool all);

/// The man page of a command, or of the whole tool (NULL), as mdoc(7).
void manual_print(FILE* stream, const command* c);

/// Shell completions for "bash", "zsh" or "fish".
void completion_print_bash(FILE* stream);
void completion_print_zsh(FILE* stream);
void completion_print_fish(FILE* stream);
