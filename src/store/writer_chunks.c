// SPDX-License-Identifier: MIT
// Octaves on their way into a file: gathered chunk by chunk, compressed on all threads, written in order.
#include "base/bytes.h"
#include "store/chunks.h"
#include "store/internal.h"
#include "store/writing.h"

#include <string.h>

enum { BATCH = 32 }; ///< chunks that are compressed at once

typedef struct packed_chunk {
    uint32_t block, chunk;
    uint32_t size, crc; ///< as stored; size 0: there was no memory
} packed_chunk;

struct stp_store_batch {
    stp_store_writing* w;
    packed_chunk chunks[BATCH];
    size_t count;
    unsigned char* bytes; ///< room for BATCH chunks
    unsigned char* table; ///< of the block being written
    size_t table_capacity;
    stp_store_packer** packers; ///< one a thread, made when first needed
    uint32_t thread_count;
};

static stp_store_octave_span span_of(const stp_store_writing* w, const stp_store_block* block)
{
    return stp_store_span_of(&w->content->surfels[block->owner], block->octave,
                             STP_STORE_ENCODING_CHUNKS);
}

stp_result stp_store_batch_create(stp_store_writing* w, stp_store_batch** batch)
{
    stp_store_batch* b = STP_NEW_ZEROED(w->context, stp_store_batch, 1);
    *batch = b;
    if (b == NULL) {
        return stp_fail_memory(w->context);
    }
    b->w = w;
    b->thread_count = stp_context_thread_count(w->context);
    b->bytes = stp_alloc_array(w->context, BATCH, STP_STORE_PIECE_BYTES);
    b->packers = STP_NEW_ZEROED(w->context, stp_store_packer*, b->thread_count);
    return b->bytes != NULL && b->packers != NULL ? STP_OK : stp_fail_memory(w->context);
}

void stp_store_batch_destroy(stp_store_batch* b)
{
    if (b == NULL) {
        return;
    }
    stp_context* context = b->w->context;
    for (uint32_t i = 0; b->packers != NULL && i < b->thread_count; ++i) {
        stp_store_packer_destroy(b->packers[i]);
    }
    stp_free(context, b->packers);
    stp_free(context, b->table);
    stp_free(context, b->bytes);
    stp_free(context, b);
}

/// Puts the columns of a chunk one after the other. @return their bytes
static size_t gather(const stp_splats* surfels, const stp_store_block* block,
                     const stp_store_octave_span* span, uint32_t chunk, unsigned char* out)
{
    uint32_t begin = chunk == 0 ? span->begin : stp_store_chunk_end(span, chunk - 1);
    size_t place = begin > span->first ? begin : span->first;
    size_t entry = (size_t)stp_store_pyramid_begin(surfels, block->octave) + begin - span->begin;
    const void* sources[STP_SURFEL_COLUMNS] = {
        [STP_SURFEL_POSITIONS] = surfels->positions + 3 * place,
        [STP_SURFEL_NORMALS] = surfels->normals + 2 * place,
        [STP_SURFEL_MATERIALS] = surfels->materials + place,
        [STP_SURFEL_COLORS] = surfels->colors + 3 * entry,
        [STP_SURFEL_COVERAGES] = surfels->coverages + entry,
        [STP_SURFEL_SHAPES] = surfels->shapes != NULL ? surfels->shapes + place : NULL,
        [STP_SURFEL_RANGES] = surfels->ranges != NULL ? surfels->ranges + place : NULL,
    };
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    size_t size = (size_t)stp_store_chunk_columns(span, chunk, columns);
    for (int i = 0; i < STP_SURFEL_COLUMNS; ++i) {
        if (columns[i].size != 0) {
            memcpy(out + columns[i].offset, sources[i], (size_t)columns[i].size);
        }
    }
    return size;
}

static void pack_chunks(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_store_batch* b = user;
    const stp_store_writing* w = b->w;
    unsigned char bytes[STP_STORE_PIECE_BYTES];
    if (b->packers[worker] == NULL && !w->content->passing) {
        b->packers[worker] = stp_store_packer_create();
    }
    for (size_t i = begin; i < end; ++i) {
        packed_chunk* chunk = &b->chunks[i];
        const stp_store_block* block = &w->plan.blocks[chunk->block];
        stp_store_octave_span span = span_of(w, block);
        unsigned char* out = b->bytes + i * STP_STORE_PIECE_BYTES;
        size_t size = gather(&w->content->surfels[block->owner], block, &span, chunk->chunk, bytes);
        bool good = b->packers[worker] != NULL || w->content->passing;
        chunk->size = good ? (uint32_t)stp_store_pack(b->packers[worker], bytes, size, out) : 0;
        chunk->crc = stp_store_crc(0, out, chunk->size);
    }
}

/// Begins a block at the end of the file, with room for its chunk table.
static stp_result begin_block(stp_store_batch* b, stp_store_block* block, size_t table_bytes)
{
    stp_store_writing* w = b->w;
    stp_result result = stp_store_pad(w);
    block->offset = stp_file_writer_size(w->file);
    block->encoding = STP_STORE_ENCODING_CHUNKS;
    unsigned char* table = stp_grow_array(w->context, b->table, &b->table_capacity, table_bytes, 1);
    if (table == NULL && table_bytes != 0) {
        return stp_fail_memory(w->context);
    }
    b->table = table;
    if (result != STP_OK || table_bytes == 0) {
        return result;
    }
    memset(table, 0, table_bytes);
    return stp_file_writer_append(w->file, table, table_bytes);
}

static stp_result write_chunk(stp_store_batch* b, const packed_chunk* chunk,
                              const unsigned char* bytes)
{
    stp_store_writing* w = b->w;
    stp_store_block* block = &w->plan.blocks[chunk->block];
    stp_store_octave_span span = span_of(w, block);
    size_t table_bytes = (size_t)stp_store_chunk_table_bytes(&span);
    if (chunk->size == 0) {
        return stp_fail_memory(w->context);
    }
    stp_result result = chunk->chunk == 0 ? begin_block(b, block, table_bytes) : STP_OK;
    if (result == STP_OK) {
        result = stp_file_writer_append(w->file, bytes, chunk->size);
    }
    block->crc = chunk->crc;
    if (result == STP_OK && table_bytes != 0) {
        unsigned char* entry = b->table + (size_t)chunk->chunk * STP_STORE_PIECE_ENTRY;
        stp_write_u32(entry, chunk->size);
        stp_write_u32(entry + 4, chunk->crc);
        if (chunk->chunk + 1 == stp_store_chunk_count(&span)) {
            block->crc = stp_store_crc(0, b->table, table_bytes);
            result = stp_file_writer_patch(w->file, block->offset, b->table, table_bytes);
        }
    }
    block->size = stp_file_writer_size(w->file) - block->offset;
    return result;
}

stp_result stp_store_batch_flush(stp_store_batch* b)
{
    stp_result result = STP_OK;
    stp_parallel_for(b->w->context, b->count, 1, pack_chunks, b);
    for (size_t i = 0; i < b->count && result == STP_OK; ++i) {
        result = write_chunk(b, &b->chunks[i], b->bytes + i * STP_STORE_PIECE_BYTES);
    }
    b->count = 0;
    return result;
}

stp_result stp_store_batch_add(stp_store_batch* b, uint32_t block)
{
    stp_store_octave_span span = span_of(b->w, &b->w->plan.blocks[block]);
    uint32_t count = stp_store_chunk_count(&span);
    stp_result result = STP_OK;
    for (uint32_t chunk = 0; chunk < count && result == STP_OK; ++chunk) {
        b->chunks[b->count++] = (packed_chunk){.block = block, .chunk = chunk};
        if (b->count == BATCH) {
            result = stp_store_batch_flush(b);
        }
    }
    return result;
}
