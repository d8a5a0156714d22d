// SPDX-License-Identifier: MIT
// A folder as listed by the file dialog: folders first, then files that can be opened.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

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
    bool cut_short; ///< there are more entries
} folder_list;

/// Supported formats, as text for people.
extern const char folder_formats[];

/// Lists a folder without hidden entries, and without unsupported files unless `all`. @return false
/// if it cannot be read: `f` stays unchanged
bool folder_read(folder_list* f, const char* path, bool all);
/// "PATH/NAME" of an entry, or the parent folder for "..". @return false if it is too long
bool folder_join(const folder_list* f, const char* name, char path[PATH_MAX]);
void folder_destroy(folder_list* f);
