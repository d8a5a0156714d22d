// SPDX-License-Identifier: MIT
#include "store/bytes/chunks.h"

#include "base/io/bytes.h"
#include "store/bytes/operators.h"

#include <assert.h>
#include <string.h>

enum {
    COLOR_BYTES = 4,  ///< a splat's colour and coverage
    LIGHT_BYTES = 3,  ///< a splat's light normal
    PLACE_BYTES = 9,  ///< a splat's position, normal and material
    OPTION_BYTES = 4, ///< a splat's shape, its range, or its errors
};

stp_store_octave_span stp_store_span_of(const stp_splats* splats, uint32_t octave,
                                        uint32_t encoding)
{
    assert(octave < splats->octave_count);
    uint32_t first = stp_store_octave_begin(splats, octave);
    return (stp_store_octave_span){
        .first = first,
        .end = splats->octave_ends[octave],
        .begin = (splats->columns & STP_SPLATS_FLAT_COLORS) != 0 ? first : 0,
        .columns = splats->columns,
        .encoding = encoding,
    };
}

static uint32_t shape_bytes(const stp_store_octave_span* span)
{
    return (span->columns & STP_SPLATS_SHAPES) != 0 ? OPTION_BYTES : 0;
}

static uint32_t range_bytes(const stp_store_octave_span* span)
{
    return (span->columns & STP_SPLATS_RANGES) != 0 ? OPTION_BYTES : 0;
}

static uint32_t error_bytes(const stp_store_octave_span* span)
{
    return (span->columns & STP_SPLATS_ERRORS) != 0 ? OPTION_BYTES : 0;
}

static uint32_t light_bytes(const stp_store_octave_span* span)
{
    return span->encoding == STP_STORE_ENCODING_LIT ? LIGHT_BYTES : 0;
}

/// Bytes of a splat in the columns that earlier splats have in this octave, too.
static uint32_t color_bytes(const stp_store_octave_span* span)
{
    return COLOR_BYTES + light_bytes(span);
}

/// Bytes of a splat in all columns of an octave.
static uint32_t bytes_per_splat(const stp_store_octave_span* span)
{
    return color_bytes(span) + PLACE_BYTES + shape_bytes(span) + range_bytes(span) +
           error_bytes(span);
}

/// Splats in a chunk that holds only colours.
static uint32_t colors_per_chunk(const stp_store_octave_span* span)
{
    return STP_STORE_CHUNK_BYTES / color_bytes(span);
}

/// Chunks that hold only colours, of splats of earlier octaves.
static uint32_t color_chunks(const stp_store_octave_span* span)
{
    return (span->first - span->begin) / colors_per_chunk(span);
}

/// End of the next chunk: the remaining colours of earlier octaves, then splats. Not yet limited
/// to the octave.
static uint64_t mixed_end(const stp_store_octave_span* span)
{
    uint32_t colors = (span->first - span->begin) % colors_per_chunk(span);
    return (uint64_t)span->first +
           (STP_STORE_CHUNK_BYTES - color_bytes(span) * colors) / bytes_per_splat(span);
}

uint32_t stp_store_chunk_count(const stp_store_octave_span* span)
{
    uint64_t mixed = mixed_end(span);
    if (span->encoding == STP_STORE_ENCODING_PLAIN) {
        return 1;
    }
    uint64_t left = span->end > mixed ? span->end - mixed : 0;
    uint64_t maximum = STP_STORE_CHUNK_BYTES / bytes_per_splat(span);
    return (uint32_t)(color_chunks(span) + 1 + (left + maximum - 1) / maximum);
}

uint32_t stp_store_chunk_end(const stp_store_octave_span* span, uint32_t chunk)
{
    assert(chunk < stp_store_chunk_count(span));
    uint32_t colors = color_chunks(span);
    uint64_t end = span->end;
    if (span->encoding != STP_STORE_ENCODING_PLAIN && chunk < colors) {
        end = span->begin + (chunk + 1) * (uint64_t)colors_per_chunk(span);
    } else if (span->encoding != STP_STORE_ENCODING_PLAIN) {
        uint32_t maximum = STP_STORE_CHUNK_BYTES / bytes_per_splat(span);
        end = mixed_end(span) + (uint64_t)(chunk - colors) * maximum;
    }
    return end < span->end ? (uint32_t)end : span->end;
}

static uint32_t chunk_begin(const stp_store_octave_span* span, uint32_t chunk)
{
    return chunk == 0 ? span->begin : stp_store_chunk_end(span, chunk - 1);
}

/// Sizes of the columns for a run of splats. @return their sum
static uint64_t measure(const stp_store_octave_span* span, uint32_t begin, uint32_t end,
                        uint64_t sizes[STP_OCTAVE_COLUMNS])
{
    assert(span->begin <= begin && begin <= end && end <= span->end);
    uint64_t colors = end - begin;
    uint64_t places = end > span->first ? end - (begin > span->first ? begin : span->first) : 0;
    sizes[STP_OCTAVE_POSITIONS] = 6 * places;
    sizes[STP_OCTAVE_NORMALS] = 2 * places;
    sizes[STP_OCTAVE_MATERIALS] = places;
    sizes[STP_OCTAVE_COLORS] = 3 * colors;
    sizes[STP_OCTAVE_COVERAGES] = colors;
    sizes[STP_OCTAVE_SHAPES] = shape_bytes(span) * places;
    sizes[STP_OCTAVE_RANGES] = range_bytes(span) * places;
    sizes[STP_OCTAVE_ERRORS] = error_bytes(span) * places;
    bool lit = light_bytes(span) != 0;
    sizes[STP_OCTAVE_TURNS] = lit ? 2 * colors : 0;
    sizes[STP_OCTAVE_SPREADS] = lit ? colors : 0;
    return (bytes_per_splat(span) - color_bytes(span)) * places + color_bytes(span) * colors;
}

uint64_t stp_store_chunk_columns(const stp_store_octave_span* span, uint32_t chunk,
                                 stp_store_column columns[STP_STORE_COLUMN_LIMIT])
{
    uint64_t sizes[STP_OCTAVE_COLUMNS], end = 0;
    measure(span, chunk_begin(span, chunk), stp_store_chunk_end(span, chunk), sizes);
    for (int i = 0; i < STP_STORE_COLUMN_LIMIT; ++i) {
        uint64_t size = i < STP_OCTAVE_COLUMNS ? sizes[i] : 0;
        columns[i] = (stp_store_column){.offset = end, .size = size};
        end += size;
    }
    assert(span->encoding == STP_STORE_ENCODING_PLAIN || end <= STP_STORE_CHUNK_BYTES);
    return end;
}

uint64_t stp_store_chunk_table_bytes(const stp_store_octave_span* span)
{
    uint64_t count = stp_store_chunk_count(span);
    return count > 1 ? count * STP_STORE_CHUNK_ENTRY : 0;
}

static uint64_t decoded_bytes(const stp_store_octave_span* span)
{
    uint64_t sizes[STP_OCTAVE_COLUMNS];
    return measure(span, span->begin, span->end, sizes);
}

bool stp_store_can_hold(const stp_store_octave_span* span, uint64_t size)
{
    uint64_t table = stp_store_chunk_table_bytes(span), decoded = decoded_bytes(span);
    if (span->encoding == STP_STORE_ENCODING_PLAIN) {
        return size == decoded;
    }
    uint64_t minimum = decoded / STP_STORE_CHUNK_RATIO, rounded = stp_store_chunk_count(span);
    return size >= table && size - table <= decoded && size - table + rounded >= minimum;
}

const char* const stp_store_unreadable = "bytes";
const char* const stp_store_no_memory = "content";

/// Read state of a block.
typedef struct block_reader {
    const stp_store_block_source* source;
    uint64_t read_bytes;
    stp_store_unpacker* unpacker; ///< created on first use
    stp_operator_reader operators;
} block_reader;

/// Reads bytes of the block from `offset` on.
static bool read_part(block_reader* at, uint64_t offset, void* bytes, size_t size)
{
    const stp_store_block_source* source = at->source;
    at->read_bytes += size;
    return source->read(source->user, source->block->offset + offset, bytes, size);
}

/// Copies bytes [begin, begin + size) of consecutive columns to their targets.
static void scatter(const stp_store_column* columns, unsigned char* const* targets,
                    const unsigned char* bytes, uint64_t begin, uint64_t size)
{
    for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
        uint64_t from = columns[i].offset > begin ? columns[i].offset : begin;
        uint64_t column_end = columns[i].offset + columns[i].size;
        uint64_t end = column_end < begin + size ? column_end : begin + size;
        if (from < end && targets[i] != NULL) {
            memcpy(targets[i] + (from - columns[i].offset), bytes + (from - begin),
                   (size_t)(end - from));
        }
    }
}

/// Reads a block of encoding 0: plain columns.
static const char* read_plain(block_reader* at, const stp_store_octave_span* span,
                              unsigned char* const* targets)
{
    unsigned char* bytes = stp_store_unpacker_rooms(&at->unpacker);
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    const stp_store_block* block = at->source->block;
    uint32_t crc = 0;
    if (bytes == NULL) {
        return stp_store_no_memory;
    }
    stp_store_chunk_columns(span, 0, columns);
    for (uint64_t done = 0; done < block->size;) {
        uint64_t left = block->size - done;
        size_t size = left < STP_STORE_CHUNK_BYTES ? (size_t)left : STP_STORE_CHUNK_BYTES;
        if (!read_part(at, done, bytes, size)) {
            return stp_store_unreadable;
        }
        crc = stp_store_crc(crc, bytes, size);
        scatter(columns, targets, bytes, done, size);
        done += size;
    }
    return crc == block->crc ? NULL : "checksum";
}

/// Checks the chunk table and finds the offset of a chunk in the block.
static const char* find_chunk(block_reader* at, const stp_store_octave_span* span, uint32_t chunk,
                              uint64_t* offset)
{
    unsigned char bytes[512 * STP_STORE_CHUNK_ENTRY];
    const stp_store_block* block = at->source->block;
    uint64_t table = stp_store_chunk_table_bytes(span), end = table;
    uint32_t crc = 0, index = 0;
    *offset = table;
    for (uint64_t done = 0; done < table;) {
        size_t size = table - done < sizeof(bytes) ? (size_t)(table - done) : sizeof(bytes);
        if (!read_part(at, done, bytes, size)) {
            return stp_store_unreadable;
        }
        crc = stp_store_crc(crc, bytes, size);
        for (size_t i = 0; i < size; i += STP_STORE_CHUNK_ENTRY, ++index) {
            *offset = index == chunk ? end : *offset;
            end += stp_read_u32(bytes + i);
        }
        done += size;
    }
    if (table != 0 && crc != block->crc) {
        return "checksum";
    }
    return table == 0 || end == block->size ? NULL : "size";
}

/// Decodes the stored bytes of a chunk into its columns. @return NULL, or the error
static const char* decode_chunk(block_reader* at, const stp_store_octave_span* span, uint32_t chunk,
                                const unsigned char* stored, size_t stored_size,
                                unsigned char* const* targets)
{
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    size_t size = (size_t)stp_store_chunk_columns(span, chunk, columns);
    assert(stored_size <= size);
    bool operators = span->encoding == STP_STORE_ENCODING_OPERATORS;
    uint32_t begin = chunk_begin(span, chunk), end = stp_store_chunk_end(span, chunk);
    if (stored_size == size) {
        scatter(columns, targets, stored, 0, size);
        if (operators) {
            stp_operators_skip(&at->operators, begin, end);
        }
        return NULL;
    }
    if (operators) {
        stp_operator_run run = {.set = at->source->set, .begin = begin, .end = end};
        bool right = stored_size >= size / STP_STORE_CHUNK_RATIO &&
                     stp_operators_decode(&run, &at->operators, stored, stored_size);
        return right ? NULL : "coding of a chunk";
    }
    unsigned char* decoded = stp_store_unpacker_rooms(&at->unpacker) + STP_STORE_CHUNK_BYTES;
    if (!stp_store_unpack(&at->unpacker, stored, stored_size, decoded, size)) {
        return "compression of a chunk";
    }
    scatter(columns, targets, decoded, 0, size);
    return NULL;
}

/// Reads and decodes one chunk at `offset` in the block. @return NULL, or the error
static const char* read_chunk(block_reader* at, const stp_store_octave_span* span, uint32_t chunk,
                              uint64_t* offset, unsigned char* const* targets)
{
    unsigned char* stored = stp_store_unpacker_rooms(&at->unpacker);
    unsigned char entry[STP_STORE_CHUNK_ENTRY];
    stp_store_column columns[STP_STORE_COLUMN_LIMIT];
    const stp_store_block* block = at->source->block;
    uint64_t size = stp_store_chunk_columns(span, chunk, columns), stored_size = block->size;
    uint32_t crc = block->crc;
    if (stored == NULL) {
        return stp_store_no_memory;
    }
    if (stp_store_chunk_table_bytes(span) != 0) {
        if (!read_part(at, (uint64_t)chunk * STP_STORE_CHUNK_ENTRY, entry, sizeof(entry))) {
            return stp_store_unreadable;
        }
        at->read_bytes -= sizeof(entry); // already counted
        stored_size = stp_read_u32(entry);
        crc = stp_read_u32(entry + 4);
    }
    if (stored_size > size || *offset > block->size || stored_size > block->size - *offset) {
        return "size of a chunk";
    }
    if (!read_part(at, *offset, stored, (size_t)stored_size)) {
        return stp_store_unreadable;
    }
    if (stp_store_crc(0, stored, (size_t)stored_size) != crc) {
        return "checksum";
    }
    *offset += stored_size;
    return decode_chunk(at, span, chunk, stored, (size_t)stored_size, targets);
}

const char* stp_store_read_chunks(const stp_store_block_source* source,
                                  const stp_store_octave_span* span, uint32_t begin, uint32_t end,
                                  void* const targets[STP_OCTAVE_COLUMNS], uint64_t* read_bytes)
{
    assert(begin <= end && end <= stp_store_chunk_count(span));
    assert(span->encoding != STP_STORE_ENCODING_OPERATORS ||
           (source->set != NULL && source->waiting != NULL));
    block_reader at = {.source = source};
    unsigned char* places[STP_OCTAVE_COLUMNS];
    uint64_t sizes[STP_OCTAVE_COLUMNS], offset = 0;
    const char* fault = NULL;
    measure(span, span->begin, chunk_begin(span, begin), sizes);
    for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
        places[i] = targets[i] != NULL ? (unsigned char*)targets[i] + sizes[i] : NULL;
    }
    if (span->encoding == STP_STORE_ENCODING_PLAIN) {
        fault = begin < end ? read_plain(&at, span, places) : NULL;
    } else {
        fault = find_chunk(&at, span, begin, &offset);
        if (span->encoding == STP_STORE_ENCODING_OPERATORS) {
            stp_operators_begin(&at.operators, source->set->ranges, chunk_begin(span, begin),
                                source->waiting);
        }
        for (uint32_t chunk = begin; fault == NULL && chunk < end; ++chunk) {
            fault = read_chunk(&at, span, chunk, &offset, places);
            measure(span, chunk_begin(span, chunk), stp_store_chunk_end(span, chunk), sizes);
            for (int i = 0; i < STP_OCTAVE_COLUMNS; ++i) {
                places[i] = places[i] != NULL ? places[i] + sizes[i] : NULL;
            }
        }
    }
    stp_store_unpacker_destroy(at.unpacker);
    *read_bytes += at.read_bytes;
    return fault;
}
