// SPDX-License-Identifier: MIT
// Files that a model may reference: those in its own folder and below. Uses no context, so that a
// forked child may call it.
#pragma once

#include <stdbool.h>
#include <stddef.h>

/// Resolves a reference: the model's folder joined with the reference, without "." and "..".
/// Rejects absolute paths, drive letters, URLs, control characters, and ".." or links that leave
/// the folder. Backslashes count as slashes. A missing file is not an error.
/// @param out room for strlen(model) + strlen(reference) + 2 bytes
/// @return NULL, or the reason for rejecting it: "it is an absolute path"
const char* stp_path_resolve(const char* model, const char* reference, char* out);

/// Length of the folder in a model's path, with its slash; 0: the current folder.
size_t stp_path_folder_length(const char* model);

/// Whether a path names a regular file, after following links.
bool stp_path_is_file(const char* path);

/// Whether a file, after following links, is in a folder (the first `folder_length` bytes of its
/// path) or below. A missing file is judged by its path.
bool stp_path_is_below(const char* path, size_t folder_length);
