// SPDX-License-Identifier: MIT
// Files whose names differ from a model's references in the ways that other systems allow.
#pragma once

#include <stdbool.h>
#include <stddef.h>

/// Looks for the file that a resolved path means if no regular file has that path: a file whose
/// name or folders differ in the case of ASCII letters, also without a query ("a.bin?v=1"). The
/// first `folder_length` bytes of `path` stay.
/// @return whether `path` names such a file now; otherwise it is unchanged
bool stp_path_find_similar(char* path, size_t folder_length);
