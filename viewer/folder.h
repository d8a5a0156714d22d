// SPDX-License-Identifier: MIT
// A folder as a dialog shows it: folders first, then the files that can be opened.
#pragma once

#include <limits.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { FOLDER_ENTRIES_MOST = 5000 };

typedef struct folder_entry {
    char* name; ///< from malloc
    bool is_folder;
    uint64_t bytes; ///< of a file
} folder_entry;

typedef struct folder_list {
    char path[PATH_MAX]; ///< absolute, without a slash at its end unless it is "/"
    folder_entry* entries;
    size_t count, capacity;
    bool cut_short; ///< there are more
} folder_list;

/// Formats that are listed, for people.
extern const char folder_formats[];

/// Whether a file's name ends as those of a format that can be opened (whatever the case of letters).
bool folder_is_model(const char* name);

/// Reads a folder; names that begin with a dot are left out, files too unless they can be opened or `all`. @return false where
/// it cannot be read: `f` stays as it was
bool folder_read(folder_list* f, const char* path, bool all);
/// "PATH/NAME" of an entry, or of the folder above for "..". @return false where it is too long
bool folder_join(const folder_list* f, const char* name, char path[PATH_MAX]);
void folder_destroy(folder_list* f);
