// SPDX-License-Identifier: MIT
//
// Octaves as chunks of at most 64 KiB, each with a checksum and compressed alone (docs/format.md, Chunks): version 1.2.
// In a block of encoding 0 (before 1.2) an octave is one chunk of any size, as it is.
#pragma once

#include "store/columns.h"
#include "store/deflate.h"

#include <stdbool.h>

enum {
    STP_STORE_ENCODING_PLAIN = 0,
    STP_STORE_ENCODING_CHUNKS = 1,
    STP_STORE_ENCODING_OPERATORS = 2, ///< chunks of a progressive set (store/operators.h)
};

/// An octave of a set: what its block holds.
typedef struct stp_store_octave_span {
    uint32_t first, end; ///< surfels that come with it
    uint32_t begin;      ///< its colours are those of surfels [begin, end): 0 but of flat colours
    uint32_t columns;    ///< STP_SPLATS_*
    uint32_t encoding;
} stp_store_octave_span;

stp_store_octave_span stp_store_span_of(const stp_splats* surfels, uint32_t octave,
                                        uint32_t encoding);
uint32_t stp_store_chunk_count(const stp_store_octave_span* span);
/// The end of the surfels that a chunk covers; it begins at the end of the one before, the first at span->begin.
uint32_t stp_store_chunk_end(const stp_store_octave_span* span, uint32_t chunk);
/// Columns of a chunk, and their bytes in all.
uint64_t stp_store_chunk_columns(const stp_store_octave_span* span, uint32_t chunk,
                                 stp_store_column columns[STP_STORE_COLUMN_LIMIT]);
/// Bytes of the chunk table at the beginning of a block: none of a single chunk.
uint64_t stp_store_chunk_table_bytes(const stp_store_octave_span* span);
/// Whether a block of so many bytes can hold the octave.
bool stp_store_can_hold(const stp_store_octave_span* span, uint64_t size);

/// Where a block is read from.
typedef struct stp_store_block_source {
    const stp_store_block* block;
    /// Reads a part of the file. @return false where it cannot
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* user;
    // Of operators alone:
    const stp_splats*
        set; ///< holds all splats before the first chunk read; the targets are its columns
    uint32_t* waiting; ///< room for an index for each splat up to the octave's end
} stp_store_block_source;

/// Room in bytes for `waiting` in that many splats.
static inline uint64_t stp_store_waiting_bytes(uint64_t splats)
{
    return splats * sizeof(uint32_t);
}

/// Of stp_store_read_chunks: the source could not give the bytes.
extern const char* const stp_store_unreadable;

/// Reads chunks [begin, end) of an octave, checks and decodes them, and puts their columns where those of the octave
/// belong (stp_store_octave_targets; NULL: a column that is not wanted). `read_bytes` is raised by the bytes read.
/// @return what of the block is wrong ("checksum"), stp_store_unreadable, or NULL. Any thread
const char* stp_store_read_chunks(const stp_store_block_source* source,
                                  const stp_store_octave_span* span, uint32_t begin, uint32_t end,
                                  void* const targets[STP_SURFEL_COLUMNS], uint64_t* read_bytes);
