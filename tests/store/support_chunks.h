// SPDX-License-Identifier: MIT
// Content with splat sets that have several chunks per octave.
#pragma once

#include "base/core/arena.h"
#include "store/writer/writer.h"

enum { CHUNK_SAMPLE_SETS = 3 };

typedef struct chunk_sample {
    stp_store_content content;
    stp_splats sets[CHUNK_SAMPLE_SETS];
    stp_shading shading;
    stp_store_method method;
} chunk_sample;

/// Three sets of up to 60,000 splats, random from `seed`; seed 0: all bytes are equal. For odd
/// seeds, sets have all optional columns; for even ones, light normals in some octaves. Do not move
/// `made`. The arena owns the memory. @return false if it runs out
bool chunk_sample_make(stp_arena* arena, uint64_t seed, chunk_sample* made);

/// Whether two sets have the same splats and colours.
bool chunk_sample_is_same(const stp_splats* a, const stp_splats* b);
