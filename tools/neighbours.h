// SPDX-License-Identifier: MIT
// The files beside a model that the model names: buffers, pictures, material libraries.
#pragma once

#include "base/file.h"
#include "base/hash.h"

/// Adds to `hash` the names, sizes and times of those files in the model's folder whose names (of three bytes or more)
/// stand in the first 16 MiB of its bytes. The order in which the folder lists them does not matter. The text is read
/// once, however many files the folder has. Where memory fails, none is added.
void neighbours_hash(const char* path, const stp_mapped_file* file, stp_hash* hash);
