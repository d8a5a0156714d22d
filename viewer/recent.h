// SPDX-License-Identifier: MIT
// The files that were opened last, kept from one start to the next in $XDG_STATE_HOME/stipple/recent (or
// ~/.local/state/stipple/recent): one path a line, the newest first.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>

enum { RECENT_MOST = 10 };

typedef struct recent_files {
    char paths[RECENT_MOST][PATH_MAX];
    size_t count;
} recent_files;

/// Puts a path first; it is in the list once, and the oldest gives way. Paths with a line end, and those that are not
/// absolute, are left out.
void recent_add(recent_files* recent, const char* path);
void recent_remove(recent_files* recent, const char* path);

/// Takes over lines of a text: absolute paths, as many as there is room for. Anything else is passed over.
void recent_parse(recent_files* recent, const char* text);

/// Reads the list; empty where there is none, or no place for it.
void recent_load(recent_files* recent);
/// Writes the list by renaming. A failure leaves the file as it was.
void recent_save(const recent_files* recent);
