// SPDX-License-Identifier: MIT
#include "store/bytes/values.h"

#include "base/io/bytes.h"
#include "store/bytes/chunks.h"

#include <assert.h>
#include <string.h>

enum { TABLE_CRC = 4, ENTRIES = 512 };

uint64_t stp_store_values_chunks(uint32_t attributes, uint64_t count)
{
    uint64_t chunks = 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        uint64_t each = stp_store_values_each((stp_attribute)a);
        chunks += stp_store_has_bit(attributes, a) ? (count + each - 1) / each : 0;
    }
    return chunks;
}

/// Uncompressed size of all values.
static uint64_t values_bytes(uint32_t attributes, uint64_t count)
{
    uint64_t bytes = 0;
    for (uint32_t a = 0; a < STP_ATTRIBUTES; ++a) {
        bytes +=
            stp_store_has_bit(attributes, a) ? count * stp_attribute_size((stp_attribute)a) : 0;
    }
    return bytes;
}

static uint64_t table_bytes(uint32_t attributes, uint64_t count)
{
    return stp_store_values_chunks(attributes, count) * STP_STORE_CHUNK_ENTRY + TABLE_CRC;
}

bool stp_store_can_hold_values(uint32_t attributes, uint64_t count, uint64_t size)
{
    uint64_t content = values_bytes(attributes, count);
    uint64_t chunks = stp_store_values_chunks(attributes, count);
    uint64_t table = table_bytes(attributes, count);
    return size >= table && size - table <= content &&
           size - table + chunks >= content / STP_STORE_CHUNK_RATIO;
}

// A value as an integer of its size.
static uint64_t read_value(const unsigned char* bytes, size_t size)
{
    uint64_t value = 0;
    for (size_t k = 0; k < size; ++k) {
        value |= (uint64_t)bytes[k] << 8 * k;
    }
    return value;
}

void stp_store_split_values(const void* values, size_t count, size_t size, bool differences,
                            unsigned char* out)
{
    assert(size >= 1 && size <= sizeof(uint64_t));
    const unsigned char* from = values;
    uint64_t before = 0;
    for (size_t i = 0; i < count; ++i) {
        uint64_t value = read_value(from + i * size, size), stored = value - before;
        before = differences ? value : 0;
        for (size_t k = 0; k < size; ++k) {
            out[k * count + i] = (unsigned char)(stored >> 8 * k);
        }
    }
}

static void join_values(const unsigned char* split, size_t count, size_t size, bool differences,
                        unsigned char* out)
{
    uint64_t before = 0;
    for (size_t i = 0; i < count; ++i) {
        uint64_t value = before;
        for (size_t k = 0; k < size; ++k) {
            value += (uint64_t)split[k * count + i] << 8 * k;
        }
        before = differences ? value : 0;
        for (size_t k = 0; k < size; ++k) {
            out[i * size + k] = (unsigned char)(value >> 8 * k);
        }
    }
}

// Reads the chunks of one attribute.
typedef struct chunk_reader {
    const stp_store_values* values;
    stp_attribute attribute;
    uint64_t first, end; ///< the requested values
    stp_store_take_values take;
    void* user;
    stp_store_unpacker* unpacker;
    uint64_t read_bytes;
} chunk_reader;

static bool read_part(chunk_reader* at, uint64_t offset, void* bytes, size_t size)
{
    at->read_bytes += size;
    return at->values->read(at->values->user, at->values->block->offset + offset, bytes, size);
}

static bool are_finite(const void* values, size_t count)
{
    bool finite = true;
    for (size_t i = 0; i < count; ++i) {
        finite = finite && isfinite(((const double*)values)[i]);
    }
    return finite;
}

// Decodes chunk `chunk` of the attribute and passes on its requested values.
static const char* take_chunk(chunk_reader* at, uint64_t chunk, uint64_t offset,
                              const unsigned char entry[STP_STORE_CHUNK_ENTRY])
{
    unsigned char* joined = stp_store_unpacker_rooms(&at->unpacker);
    if (joined == NULL) {
        return stp_store_no_memory;
    }
    unsigned char *stored = joined + STP_STORE_CHUNK_BYTES, *split = stored + STP_STORE_CHUNK_BYTES;
    size_t size = stp_attribute_size(at->attribute);
    uint64_t each = stp_store_values_each(at->attribute), begin = chunk * each;
    uint64_t left = at->values->count - begin, count = left < each ? left : each;
    assert(begin < at->values->count && "the chunk exists");
    size_t bytes = (size_t)count * size, stored_size = stp_read_u32(entry);
    if (stored_size > bytes) {
        return "size of a chunk";
    }
    if (!read_part(at, offset, stored, stored_size)) {
        return stp_store_unreadable;
    }
    if (stp_store_crc(0, stored, stored_size) != stp_read_u32(entry + 4)) {
        return "checksum";
    }
    bool plain = stored_size == bytes;
    if (!plain && !stp_store_unpack(&at->unpacker, stored, stored_size, split, bytes)) {
        return "compression of a chunk";
    }
    bool differences = at->values->block->kind == STP_BLOCK_POINT_ATTRIBUTES;
    join_values(plain ? stored : split, (size_t)count, size, differences, joined);
    if (at->attribute == STP_ATTRIBUTE_TIME && !are_finite(joined, (size_t)count)) {
        return "time of a point";
    }
    uint64_t from = at->first > begin ? at->first : begin;
    uint64_t to = at->end < begin + count ? at->end : begin + count;
    assert(from < to && "only chunks with requested values are decoded");
    at->take(at->user, from, joined + (from - begin) * size, (size_t)(to - from));
    return NULL;
}

// Walks the table: adds up the positions of chunks, and reads those of [begin, end). With `take`
// false, only checks the table.
static const char* walk_table(chunk_reader* at, uint64_t begin, uint64_t end, bool take)
{
    unsigned char bytes[ENTRIES * STP_STORE_CHUNK_ENTRY], crc_bytes[TABLE_CRC];
    const stp_store_values* v = at->values;
    assert(stp_store_can_hold_values(v->attributes, v->count, v->block->size));
    uint64_t chunks = stp_store_values_chunks(v->attributes, v->count), offset = 0;
    uint64_t table = v->block->size - table_bytes(v->attributes, v->count);
    uint64_t before =
        stp_store_values_chunks(v->attributes & (stp_attribute_bit(at->attribute) - 1), v->count);
    uint32_t crc = 0;
    const char* fault = NULL;
    for (uint64_t done = 0; done < chunks && (!take || done < end) && fault == NULL;) {
        uint64_t left = chunks - done, count = left < ENTRIES ? left : ENTRIES;
        size_t size = (size_t)count * STP_STORE_CHUNK_ENTRY;
        if (!read_part(at, table + done * STP_STORE_CHUNK_ENTRY, bytes, size)) {
            return stp_store_unreadable;
        }
        crc = stp_store_crc(crc, bytes, size);
        for (size_t i = 0; i < count && fault == NULL; ++i, ++done) {
            const unsigned char* entry = bytes + i * STP_STORE_CHUNK_ENTRY;
            uint64_t stored = stp_read_u32(entry);
            assert(offset <= table && "chunks precede their table");
            fault = stored > table - offset ? "size of a chunk" : NULL;
            if (fault == NULL && take && done >= begin && done < end) {
                fault = take_chunk(at, done - before, offset, entry);
            }
            offset += stored;
        }
    }
    if (fault != NULL || take) {
        return fault;
    }
    if (!read_part(at, v->block->size - TABLE_CRC, crc_bytes, TABLE_CRC)) {
        return stp_store_unreadable;
    }
    return stp_read_u32(crc_bytes) != crc ? "checksum" : offset != table ? "size" : NULL;
}

const char* stp_store_read_values(const stp_store_values* values, stp_attribute attribute,
                                  uint64_t first, uint64_t end, stp_store_take_values take,
                                  void* user, uint64_t* read_bytes)
{
    chunk_reader at = {.values = values,
                       .attribute = attribute,
                       .first = first,
                       .end = end,
                       .take = take,
                       .user = user};
    if (first >= end) {
        return NULL;
    }
    assert(end <= values->count && stp_store_has_bit(values->attributes, attribute));
    uint64_t each = stp_store_values_each(attribute);
    uint64_t before = stp_store_values_chunks(
        values->attributes & (stp_attribute_bit(attribute) - 1), values->count);
    const char* fault = walk_table(&at, 0, 0, false);
    if (fault == NULL) {
        fault = walk_table(&at, before + first / each, before + (end + each - 1) / each, true);
    }
    stp_store_unpacker_destroy(at.unpacker);
    *read_bytes += at.read_bytes;
    return fault;
}
