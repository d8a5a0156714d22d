// SPDX-License-Identifier: MIT
// Files next to a model that it references: buffers, pictures, material libraries.
#pragma once

#include "base/io/file.h"
#include "base/io/hash.h"

/// Adds to `hash` the name, size and time of each file in the model's folder whose name (three
/// bytes or more) occurs in the model's first 16 MiB. The folder's listing order does not matter.
/// The text is read once for any number of files. If memory runs out, nothing is added.
void neighbours_hash(const char* path, const stp_mapped_file* file, stp_hash* hash);
