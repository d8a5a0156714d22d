// SPDX-License-Identifier: MIT
// Writes octaves: gathers them chunk by chunk, compresses on all threads, writes in order.
// Progressive sets are coded as operators, others with DEFLATE.
#include "base/io/bytes.h"
#include "base/splats/light_normal.h"
#include "store/bytes/chunks.h"
#include "store/bytes/operators.h"
#include "store/writer/writing.h"

#include <assert.h>
#include <string.h>

enum {
    BATCH = 32,                                  ///< chunks compressed at once
    SPLITS_MAX = STP_STORE_CHUNK_BYTES / 42 + 2, ///< splits in a chunk: two splats take 42 bytes
};

typedef struct packed_chunk {
    uint32_t block, chunk;
    uint32_t size, crc; ///< as stored; size 0: out of memory
    uint32_t encoding;
    uint32_t base; ///< operators: number of base splats before the chunk
} packed_chunk;

struct stp_store_batch {
    stp_store_writing* w;
    packed_chunk chunks[BATCH];
    size_t count;
    unsigned char* bytes;    ///< room for BATCH chunks
    unsigned char* gathered; ///< room for a chunk of each thread
    uint32_t* parents;       ///< operators: SPLITS_MAX per chunk
    unsigned char* table;    ///< chunk table of the block being written
    size_t table_capacity;
    stp_store_packer** packers; ///< one per thread, created on first use
    uint32_t thread_count;
};

static stp_store_octave_span span_of(const stp_store_writing* w, const stp_store_block* block)
{
    const stp_splats* set = &w->content->sets[block->owner];
    bool lit = stp_has_light_normals(set, block->octave);
    return stp_store_span_of(set, block->octave,
                             lit ? STP_STORE_ENCODING_LIT : STP_STORE_ENCODING_CHUNKS);
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
    b->bytes = stp_alloc_array(w->context, BATCH, STP_STORE_CHUNK_BYTES);
    b->gathered = stp_alloc_array(w->context, b->thread_count, STP_STORE_CHUNK_BYTES);
    b->packers = STP_NEW_ZEROED(w->context, stp_store_packer*, b->thread_count);
    return b->bytes != NULL && b->gathered != NULL && b->packers != NULL
               ? STP_OK
               : stp_fail_memory(w->context);
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
    stp_free(context, b->parents);
    stp_free(context, b->table);
    stp_free(context, b->gathered);
    stp_free(context, b->bytes);
    stp_free(context, b);
}

/// Concatenates the columns of a chunk. @return their size
static size_t gather(const stp_splats* splats, const stp_store_block* block,
                     const stp_store_octave_span* span, uint32_t chunk, unsigned char* out)
{
    uint32_t begin = chunk == 0 ? span->begin : stp_store_chunk_end(span, chunk - 1);
    size_t place = begin > span->first ? begin : span->first;
    size_t entry = (size_t)stp_store_pyramid_begin(splats, block->octave) + begin - span->begin;
    stp_light_normals lights = stp_light_normals_of(splats, block->octave);
    const void* sources[STP_OCTAVE_COLUMNS] = {
        [STP_OCTAVE_POSITIONS] = splats->positions + 3 * place,
        [STP_OCTAVE_NORMALS] = splats->normals + 2 * place,
        [STP_OCTAVE_MATERIALS] = splats->materials + place,
        [STP_OCTAVE_COLORS] = splats->colors + 3 * entry,
        [STP_OCTAVE_COVERAGES] = splats->coverages + entry,
        [STP_OCTAVE_SHAPES] = splats->shapes != NULL ? splats->shapes + place : NULL,
        [STP_OCTAVE_RANGES] = splats->ranges != NULL ? splats->ranges + place : NULL,
        [STP_OCTAVE_ERRORS] = splats->errors != NULL ? splats->errors + place : NULL,
        [STP_OCTAVE_TURNS] = lights.turns != NULL ? lights.turns + 2 * (size_t)begin : NULL,
        [STP_OCTAVE_SPREADS] = lights.spreads != NULL ? lights.spreads + begin : NULL,
    };
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    size_t size = (size_t)stp_store_chunk_columns(span, chunk, columns);
    for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
        if (columns[i].size != 0) {
            memcpy(out + columns[i].offset, sources[i], (size_t)columns[i].size);
        }
    }
    return size;
}

/// Codes a chunk as operators. Keeps plain columns if operators take `size` bytes or more.
static size_t pack_operators(const stp_store_batch* b, size_t index, const unsigned char* columns,
                             size_t size, unsigned char* out)
{
    const packed_chunk* chunk = &b->chunks[index];
    const stp_store_block* block = &b->w->plan.blocks[chunk->block];
    stp_store_octave_span span = span_of(b->w, block);
    stp_operator_run run = {
        .set = &b->w->content->sets[block->owner],
        .begin = chunk->chunk == 0 ? span.begin : stp_store_chunk_end(&span, chunk->chunk - 1),
        .end = stp_store_chunk_end(&span, chunk->chunk),
        .base = chunk->base,
    };
    size_t minimum = size / STP_STORE_CHUNK_RATIO;
    size_t made = stp_operators_encode(&run, b->parents + index * SPLITS_MAX, out, size - 1);
    if (made == 0) {
        memcpy(out, columns, size);
        return size;
    }
    if (made < minimum) { // as stp_store_pack does
        memset(out + made, 0, minimum - made);
        made = minimum;
    }
    assert(made < size && "a chunk of full size is read as columns");
    return made;
}

static void pack_chunks(size_t begin, size_t end, uint32_t worker, void* user)
{
    stp_store_batch* b = user;
    const stp_store_writing* w = b->w;
    unsigned char* bytes = b->gathered + (size_t)worker * STP_STORE_CHUNK_BYTES;
    if (b->packers[worker] == NULL && !w->content->passing) {
        b->packers[worker] = stp_store_packer_create();
    }
    for (size_t i = begin; i < end; ++i) {
        packed_chunk* chunk = &b->chunks[i];
        const stp_store_block* block = &w->plan.blocks[chunk->block];
        stp_store_octave_span span = span_of(w, block);
        unsigned char* out = b->bytes + i * STP_STORE_CHUNK_BYTES;
        size_t size = gather(&w->content->sets[block->owner], block, &span, chunk->chunk, bytes);
        bool good = b->packers[worker] != NULL || w->content->passing;
        if (chunk->encoding == STP_STORE_ENCODING_OPERATORS) {
            chunk->size = (uint32_t)pack_operators(b, i, bytes, size, out);
        } else {
            chunk->size = good ? (uint32_t)stp_store_pack(b->packers[worker], bytes, size, out) : 0;
        }
        chunk->crc = stp_store_crc(0, out, chunk->size);
    }
}

/// Begins a block at the end of the file, with room for its chunk table.
static stp_result begin_block(stp_store_batch* b, stp_store_block* block, uint32_t encoding,
                              size_t table_bytes)
{
    stp_store_writing* w = b->w;
    stp_result result = stp_store_pad(w);
    block->offset = stp_file_writer_size(w->file);
    block->encoding = encoding;
    if (result != STP_OK || table_bytes == 0) {
        return result;
    }
    if (!STP_MAKE_ROOM(w->context, b->table, b->table_capacity, table_bytes)) {
        return stp_fail_memory(w->context);
    }
    memset(b->table, 0, table_bytes);
    return stp_file_writer_append(w->file, b->table, table_bytes);
}

static stp_result write_chunk(stp_store_batch* b, const packed_chunk* chunk,
                              const unsigned char* bytes)
{
    stp_store_writing* w = b->w;
    stp_store_block* block = &w->plan.blocks[chunk->block];
    stp_store_octave_span span = span_of(w, block);
    assert(chunk->chunk < stp_store_chunk_count(&span));
    size_t table_bytes = (size_t)stp_store_chunk_table_bytes(&span);
    if (chunk->size == 0) {
        return stp_fail_memory(w->context);
    }
    stp_result result =
        chunk->chunk == 0 ? begin_block(b, block, chunk->encoding, table_bytes) : STP_OK;
    if (result == STP_OK) {
        result = stp_file_writer_append(w->file, bytes, chunk->size);
    }
    block->crc = chunk->crc;
    if (result == STP_OK && table_bytes != 0) {
        unsigned char* entry = b->table + (size_t)chunk->chunk * STP_STORE_CHUNK_ENTRY;
        stp_write_u32(entry, chunk->size);
        stp_write_u32(entry + 4, chunk->crc);
        if (chunk->chunk + 1 == stp_store_chunk_count(&span)) {
            block->crc = stp_store_crc(0, b->table, table_bytes);
            result = stp_file_writer_patch(w->file, block->offset, b->table, table_bytes);
        }
    }
    block->size = stp_file_writer_size(w->file) - block->offset;
    assert(result != STP_OK || chunk->chunk + 1 < stp_store_chunk_count(&span) ||
           stp_store_can_hold(&span, block->size));
    return result;
}

stp_result stp_store_batch_flush(stp_store_batch* b)
{
    stp_result result = STP_OK;
    stp_parallel_for(b->w->context, b->count, 1, pack_chunks, b);
    for (size_t i = 0; i < b->count && result == STP_OK; ++i) {
        result = write_chunk(b, &b->chunks[i], b->bytes + i * STP_STORE_CHUNK_BYTES);
    }
    b->count = 0;
    return result;
}

/// Finds the order in which the parents of a set are split; `*order` stays NULL if it is not a
/// progressive set.
static stp_result find_order(stp_store_batch* b, const stp_splats* set, uint32_t** order)
{
    stp_context* context = b->w->context;
    *order = NULL;
    if (set->columns != STP_OPERATOR_COLUMNS || b->w->content->passing) {
        return STP_OK;
    }
    if (b->parents == NULL) {
        b->parents = STP_NEW_ARRAY(context, uint32_t, (size_t)BATCH * SPLITS_MAX);
    }
    uint32_t* found = STP_NEW_ARRAY(context, uint32_t, set->count);
    uint32_t* scratch = STP_NEW_ARRAY(context, uint32_t, set->count);
    bool made = b->parents != NULL && found != NULL && scratch != NULL;
    if (made) {
        stp_progressive_order(set->ranges, set->count, found, scratch);
    }
    if (made && stp_progressive_is_whole(set->ranges, set->count, found)) {
        *order = found;
        found = NULL;
    }
    stp_free(context, found);
    stp_free(context, scratch);
    return made ? STP_OK : stp_fail_memory(context);
}

/// Collects the parents of the splits that begin or continue in a chunk.
static void take_parents(stp_store_batch* b, uint32_t base, uint32_t begin, uint32_t end,
                         const uint32_t* order)
{
    packed_chunk* chunk = &b->chunks[b->count];
    chunk->encoding = STP_STORE_ENCODING_OPERATORS;
    chunk->base = begin < base ? begin : base;
    if (end > base) {
        uint32_t first = begin > base ? (begin - base) / 2 : 0, last = (end - base + 1) / 2;
        assert(first <= last && last - first <= SPLITS_MAX);
        memcpy(b->parents + b->count * SPLITS_MAX, order + first, (last - first) * sizeof(*order));
    }
}

stp_result stp_store_batch_add(stp_store_batch* b, uint32_t block)
{
    const stp_splats* set = &b->w->content->sets[b->w->plan.blocks[block].owner];
    stp_store_octave_span span = span_of(b->w, &b->w->plan.blocks[block]);
    uint32_t count = stp_store_chunk_count(&span), begin = span.begin;
    uint32_t* order = NULL;
    stp_result result = find_order(b, set, &order);
    uint32_t base = order != NULL ? stp_progressive_count(set->ranges, set->count).base : 0;
    for (uint32_t chunk = 0; chunk < count && result == STP_OK; ++chunk) {
        uint32_t end = stp_store_chunk_end(&span, chunk);
        assert(b->count < BATCH && begin < end);
        b->chunks[b->count] =
            (packed_chunk){.block = block, .chunk = chunk, .encoding = span.encoding};
        if (order != NULL) {
            take_parents(b, base, begin, end, order);
        }
        b->count += 1;
        begin = end;
        if (b->count == BATCH) {
            result = stp_store_batch_flush(b);
        }
    }
    assert(result != STP_OK || begin == span.end);
    stp_free(b->w->context, order);
    return result;
}
