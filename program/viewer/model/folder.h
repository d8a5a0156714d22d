// SPDX-License-Identifier: MIT
// Files to open: a folder as listed by the file dialog, and recently opened files.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// A folder as listed by the file dialog: folders first, then files that can be opened.

enum { FOLDER_ENTRIES_MAX = 5000 };

typedef struct folder_entry {
    char* name; ///< malloc'ed
    bool is_folder;
    uint64_t bytes; ///< for files
} folder_entry;

typedef struct folder_list {
    char path[PATH_MAX]; ///< absolute, without a trailing slash except for "/"
    folder_entry* entries;
    size_t count, capacity;
    bool is_truncated; ///< there are more entries
} folder_list;

/// Supported formats, as text for people. @return text
const char* folder_formats(char* text, size_t size);

/// Lists a folder without hidden entries, and without unsupported files unless `all`. @return false
/// if it cannot be read: `f` stays unchanged
bool folder_read(folder_list* f, const char* path, bool all);
/// "PATH/NAME" of an entry, or the parent folder for "..". @return false if it is too long
bool folder_join(const folder_list* f, const char* name, char path[PATH_MAX]);
void folder_destroy(folder_list* f);

/// Whether an entry's name contains what was typed, ignoring case.
bool folder_filter(const folder_entry* entry, const char* typed);
/// The longest beginning that all names have which begin with `start`, ignoring case; of a single
/// folder, with a slash. @return false if there is no such name
bool folder_complete(const folder_list* f, const char* start, char* name, size_t size);

// Recently opened files, kept in $XDG_STATE_HOME/stipple/recent (or ~/.local/state/stipple/recent):
// one path per line, newest first.

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
