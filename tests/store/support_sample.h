// SPDX-License-Identifier: MIT
// A random scene to be written, and the comparison of an opened one with it.
#pragma once

#include "base/arena.h"
#include "store/writer.h"

/// Everything a file can hold, a few of each, drawn from `seed`. Memory is the arena's; NULL arrays
/// where that runs out are never read: `complete` is false then.
typedef struct sample {
    stp_store_content content;
    bool complete;
} sample;

sample sample_make(stp_arena* arena, uint64_t seed);

/// Codes every second mesh of the sample, in the same arena, on grids of these steps (NULL: as they are chosen): false
/// where memory runs out.
bool sample_code_meshes(stp_arena* arena, sample* made, const double* steps);

/// NULL where the store holds exactly the content; else what differs first.
const char* sample_difference(const stp_store_content* content, stp_store* store);

/// The bytes of a file, in memory that is exactly as large (free() it); NULL where it cannot be
/// read.
unsigned char* sample_read_file(const char* path, size_t* size);
