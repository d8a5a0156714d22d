// SPDX-License-Identifier: MIT
//
// Octaves as chunks of at most 64 KiB (docs/format.md, Chunks). Each chunk has a checksum and is
// compressed alone. Since version 1.2. In a block of encoding 0 (before 1.2), an octave is one
// uncompressed chunk of any size.
#pragma once

#include "store/bytes/columns.h"
#include "store/bytes/deflate.h"

#include <stdbool.h>

enum {
    STP_STORE_ENCODING_PLAIN = 0,
    STP_STORE_ENCODING_CHUNKS = 1,
    STP_STORE_ENCODING_OPERATORS = 2, ///< chunks of a progressive set (store/bytes/operators.h)
    STP_STORE_ENCODING_LIT = 3,       ///< chunks with light normals (base/splats/light_normal.h)
};

/// Contents of an octave's block.
typedef struct stp_store_octave_span {
    uint32_t first, end; ///< splats that the octave adds
    uint32_t begin;      ///< it colours splats [begin, end); 0 unless colours are flat
    uint32_t columns;    ///< STP_SPLATS_*
    uint32_t encoding;
} stp_store_octave_span;

stp_store_octave_span stp_store_span_of(const stp_splats* splats, uint32_t octave,
                                        uint32_t encoding);
uint32_t stp_store_chunk_count(const stp_store_octave_span* span);
/// End of the splats that a chunk covers. A chunk begins where the one before ends; the first
/// begins at span->begin.
uint32_t stp_store_chunk_end(const stp_store_octave_span* span, uint32_t chunk);
/// The columns of a chunk. @return their total size
uint64_t stp_store_chunk_columns(const stp_store_octave_span* span, uint32_t chunk,
                                 stp_store_column columns[STP_STORE_COLUMN_LIMIT]);
/// Bytes of the chunk table at the beginning of a block; 0 for a single chunk.
uint64_t stp_store_chunk_table_bytes(const stp_store_octave_span* span);
/// Whether a block of this size can hold the octave.
bool stp_store_can_hold(const stp_store_octave_span* span, uint64_t size);

/// Source of a block's bytes.
typedef struct stp_store_block_source {
    const stp_store_block* block;
    /// Reads a part of the file. @return false on failure
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* user;
    // Only for operators:
    /// Holds all splats before the first chunk read; the targets are its columns.
    const stp_splats* set;
    uint32_t* waiting; ///< room for one index per splat up to the octave's end
} stp_store_block_source;

/// Bytes of `waiting` for this many splats.
static inline uint64_t stp_store_waiting_bytes(uint64_t splats)
{
    return splats * sizeof(uint32_t);
}

/// Fault that stp_store_read_chunks returns if the source failed.
extern const char* const stp_store_unreadable;
/// Fault if memory runs out.
extern const char* const stp_store_no_memory;

/// Reads, checks and decodes chunks [begin, end) of an octave into its columns
/// (stp_store_octave_targets; NULL skips a column). Adds the bytes read to `read_bytes`.
/// @return NULL, or the error in the block ("checksum"), or stp_store_unreadable, or
/// stp_store_no_memory. Any thread
const char* stp_store_read_chunks(const stp_store_block_source* source,
                                  const stp_store_octave_span* span, uint32_t begin, uint32_t end,
                                  void* const targets[STP_OCTAVE_COLUMNS], uint64_t* read_bytes);
