// SPDX-License-Identifier: MIT
// A random scene to write, and its comparison with an opened one.
#pragma once

#include "base/core/arena.h"
#include "store/writer/writer.h"

/// Every kind of content, a few of each, random from `seed`, in the arena's memory. If that runs
/// out, `complete` is false, and NULL arrays are never read.
typedef struct sample {
    stp_store_content content;
    bool complete;
} sample;

sample sample_make(stp_arena* arena, uint64_t seed);

/// Codes every second mesh of the sample, in the same arena, with these grid steps (NULL:
/// automatic). False if memory runs out.
bool sample_code_meshes(stp_arena* arena, sample* made, const double* steps);

/// NULL if the store holds exactly the content; else the first difference.
const char* sample_difference(const stp_store_content* content, stp_store* store);

/// The bytes of a file in memory of exactly that size (free() it); NULL on failure.
unsigned char* sample_read_file(const char* path, size_t* size);

/// Opens and fully checks a file in memory. @return STP_OK only if nothing is wrong
stp_result sample_check(stp_context* context, const unsigned char* bytes, size_t size);
