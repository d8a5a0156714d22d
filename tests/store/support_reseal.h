// SPDX-License-Identifier: MIT
// Recomputes the checksums of a damaged file, so that the checks behind them are reached.
#pragma once

#include "base/io/bytes.h"
#include "store/bytes/format.h"
#include "store/bytes/packed.h"

#include <zlib.h>

static inline uint32_t reseal_crc(const unsigned char* bytes, size_t size, uint64_t offset,
                                  uint64_t length)
{
    if (length == 0 || offset > size || length > size - offset) {
        return 0;
    }
    return (uint32_t)crc32_z(0, bytes + offset, (size_t)length);
}

// Entry of a section in the section table; NULL if the file has none of the type.
static inline unsigned char* find_section(unsigned char* bytes, uint32_t type)
{
    for (uint32_t i = 0; i < stp_read_u32(bytes + 32); ++i) {
        unsigned char* entry = bytes + STP_STORE_HEADER_BYTES + i * STP_STORE_SECTION_BYTES;
        if (stp_read_u32(entry) == type) {
            return entry;
        }
    }
    return NULL;
}

// Reseals the chunks of an octave, in its chunk table. The first size gives the number of chunks,
// because chunks follow the table. @return the table's size; 0: one chunk, or an impossible table
static inline uint64_t reseal_chunks(unsigned char* bytes, size_t size, uint64_t offset,
                                     uint64_t length)
{
    if (offset > size || length > size - offset) {
        return 0;
    }
    uint64_t sum = length >= 8 ? stp_read_u32(bytes + offset) : 0; // sum of the chunks' sizes
    for (uint64_t count = 2; 8 * count <= length && count < 64; ++count) {
        sum += stp_read_u32(bytes + offset + 8 * (count - 1));
        if (8 * count + sum != length) {
            continue;
        }
        uint64_t at = offset + 8 * count;
        for (uint64_t i = 0; i < count; ++i) {
            unsigned char* entry = bytes + offset + 8 * i;
            uint32_t chunk = stp_read_u32(entry);
            stp_write_u32(entry + 4, reseal_crc(bytes, size, at, chunk));
            at += chunk;
        }
        return 8 * count;
    }
    return 0;
}

// Reseals an attribute block: its chunks, in the table behind them, and the table. The sizes give
// the number of chunks: they add up to the table's offset.
static inline void reseal_values(unsigned char* bytes, size_t size, uint64_t offset,
                                 uint64_t length)
{
    if (offset > size || length > size - offset) {
        return;
    }
    for (uint64_t count = 1; 8 * count + 4 <= length && count < 64; ++count) {
        uint64_t table = length - 8 * count - 4, sum = 0;
        unsigned char* entries = bytes + offset + table;
        for (uint64_t i = 0; i < count; ++i) {
            sum += stp_read_u32(entries + 8 * i);
        }
        if (sum != table) {
            continue;
        }
        uint64_t at = offset;
        for (uint64_t i = 0; i < count; ++i) {
            uint32_t chunk = stp_read_u32(entries + 8 * i);
            stp_write_u32(entries + 8 * i + 4, reseal_crc(bytes, size, at, chunk));
            at += chunk;
        }
        stp_write_u32(entries + 8 * count, reseal_crc(bytes, size, offset + table, 8 * count));
        return;
    }
}

// Reseals the blocks, in the block table at `offset`.
static inline void reseal_blocks(unsigned char* bytes, size_t size, uint64_t offset,
                                 uint64_t length, uint32_t record_size)
{
    if (record_size < 40 || offset > size || length > size - offset) {
        return;
    }
    for (uint64_t at = 0; at + record_size <= length; at += record_size) {
        unsigned char* record = bytes + offset + at;
        uint64_t begin = stp_read_u64(record + 16), length_of_block = stp_read_u64(record + 24);
        if (stp_read_u32(record) >= STP_BLOCK_ATTRIBUTES) {
            reseal_values(bytes, size, begin, length_of_block);
        }
        uint64_t table = stp_read_u32(record + 36) - 1 < 2
                             ? reseal_chunks(bytes, size, begin, length_of_block)
                             : 0;
        stp_write_u32(record + 12,
                      reseal_crc(bytes, size, begin, table != 0 ? table : length_of_block));
    }
}

static inline stp_store_section reseal_section(const unsigned char* entry)
{
    return (stp_store_section){
        .type = stp_read_u32(entry),
        .flags = stp_read_u32(entry + 4),
        .offset = stp_read_u64(entry + 8),
        .size = stp_read_u64(entry + 16),
        .count = stp_read_u64(entry + 24),
        .record_size = stp_read_u32(entry + 32),
    };
}

// Reseals the pages of a packed section. @return the checksum of their table
static inline uint32_t reseal_packed(unsigned char* bytes, size_t size,
                                     const stp_store_section* section)
{
    if (section->record_size == 0 || section->offset > size ||
        section->size > size - section->offset || !stp_store_can_pack(section)) {
        return 0;
    }
    uint64_t table = stp_store_packed_table_bytes(section), at = section->offset + table;
    for (uint64_t i = 0; i < table; i += STP_STORE_CHUNK_ENTRY) {
        unsigned char* entry = bytes + section->offset + i;
        uint32_t page = stp_read_u32(entry);
        stp_write_u32(entry + 4, reseal_crc(bytes, size, at, page));
        at += page;
    }
    return reseal_crc(bytes, size, section->offset, table);
}

// Reseals the pages of all unpacked sections, in the section at `offset`.
static inline void reseal_pages(unsigned char* bytes, size_t size, uint64_t table, uint64_t offset,
                                uint64_t length, uint32_t record_size)
{
    uint64_t page = 0;
    if (record_size < 4 || offset > size || length > size - offset) {
        return;
    }
    for (uint64_t at = 0; at < table && STP_STORE_HEADER_BYTES + at + 40 <= size; at += 40) {
        const unsigned char* entry = bytes + STP_STORE_HEADER_BYTES + at;
        uint64_t begin = stp_read_u64(entry + 8), left = stp_read_u64(entry + 16);
        if (stp_read_u32(entry) == STP_SECTION_PAGES ||
            (stp_read_u32(entry + 4) & STP_SECTION_PACKED) != 0 || begin > size ||
            left > size - begin) {
            continue;
        }
        while (left != 0 && (page + 1) * record_size <= length) {
            uint64_t step = left < STP_STORE_PAGE_BYTES ? left : STP_STORE_PAGE_BYTES;
            stp_write_u32(bytes + offset + page * record_size,
                          reseal_crc(bytes, size, begin, step));
            page += 1;
            begin += step;
            left -= step;
        }
    }
}

static inline void reseal(unsigned char* bytes, size_t size)
{
    if (size < STP_STORE_HEADER_BYTES) {
        return;
    }
    uint32_t sections = stp_read_u32(bytes + 32);
    sections = sections > STP_STORE_SECTION_LIMIT ? 0 : sections;
    uint64_t table = (uint64_t)sections * STP_STORE_SECTION_BYTES;
    for (uint64_t at = 0; at < table && STP_STORE_HEADER_BYTES + at + 40 <= size; at += 40) {
        unsigned char* entry = bytes + STP_STORE_HEADER_BYTES + at;
        uint64_t offset = stp_read_u64(entry + 8), length = stp_read_u64(entry + 16);
        if (stp_read_u32(entry) == STP_SECTION_BLOCKS) {
            reseal_blocks(bytes, size, offset, length, stp_read_u32(entry + 32));
        }
    }
    for (int pass = 0; pass < 2; ++pass) { // the section of checksums has a checksum itself
        for (uint64_t at = 0; at < table && STP_STORE_HEADER_BYTES + at + 40 <= size; at += 40) {
            unsigned char* entry = bytes + STP_STORE_HEADER_BYTES + at;
            uint64_t offset = stp_read_u64(entry + 8), length = stp_read_u64(entry + 16);
            if (pass == 0 && stp_read_u32(entry) == STP_SECTION_PAGES) {
                reseal_pages(bytes, size, table, offset, length, stp_read_u32(entry + 32));
            } else if (pass == 1) {
                stp_store_section section = reseal_section(entry);
                stp_write_u32(entry + 36, stp_store_is_packed(&section)
                                              ? reseal_packed(bytes, size, &section)
                                              : reseal_crc(bytes, size, offset, length));
            }
        }
    }
    stp_write_u32(bytes + 36, reseal_crc(bytes, size, STP_STORE_HEADER_BYTES, table));
    stp_write_u32(bytes + 124, reseal_crc(bytes, size, 0, 124));
}
