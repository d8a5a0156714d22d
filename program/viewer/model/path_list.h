// SPDX-License-Identifier: MIT
// The files that are shown together.
#pragma once

#include <stdbool.h>
#include <stddef.h>

enum { PATH_LIST_MAX = 10000 };

typedef struct path_list {
    char** paths; ///< malloc'ed, as each path
    size_t count;
} path_list;

/// Adds a copy of a path. @return false if memory runs out or the list is full
bool path_list_add(path_list* list, const char* path);
/// Adds a path; of a folder, the models in it, in the order of their names. @return false if memory
/// runs out or the list is full
bool path_list_expand(path_list* list, const char* path);
void path_list_destroy(path_list* list);
