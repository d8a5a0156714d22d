// SPDX-License-Identifier: MIT
// Recently opened files, kept in $XDG_STATE_HOME/stipple/recent (or ~/.local/state/stipple/recent):
// one path per line, newest first.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

enum { RECENT_MAX = 10 };

typedef struct recent_files {
    char paths[RECENT_MAX][PATH_MAX];
    size_t count;
} recent_files;

/// Moves or adds a path to the front and drops the oldest if the list is full. Ignores relative
/// paths and paths with line breaks.
void recent_add(recent_files* recent, const char* path);
void recent_remove(recent_files* recent, const char* path);

/// Adds absolute paths from the lines of a text, as many as fit. Ignores anything else.
void recent_parse(recent_files* recent, const char* text);

/// Reads the list; empty if there is none, or no folder for it.
void recent_load(recent_files* recent);
/// Writes the list to a temporary file and renames it. On failure the file stays unchanged.
void recent_save(const recent_files* recent);
