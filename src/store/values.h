// SPDX-License-Identifier: MIT
// A block of attributes: chunks of values, a table of them, and its checksum.
//
//   chunks of the first attribute | chunks of the second | ... | size and checksum of each chunk | checksum of the table
//
// A chunk holds as many values as take 64 KiB, byte by byte: all lowest bytes first. Of point sets they are differences from the
// value before.
#pragma once

#include "store/deflate.h"
#include "store/format.h"

#include <stipple/attributes.h>

enum { STP_STORE_VALUES_ENCODING = 0 };

/// What a block of attributes holds, and where it is read from.
typedef struct stp_store_values {
    const stp_store_block* block;
    uint32_t attributes; ///< a bit each
    uint64_t count;      ///< values of each
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* user;
} stp_store_values;

/// Values of a chunk.
static inline uint32_t stp_store_values_each(stp_attribute attribute)
{
    return (uint32_t)(STP_STORE_PIECE_BYTES / stp_attribute_size(attribute));
}

static inline bool stp_store_has_bit(uint32_t attributes, uint32_t attribute)
{
    return (attributes >> attribute & 1) != 0;
}

/// Chunks of so many values of each attribute.
uint64_t stp_store_values_chunks(uint32_t attributes, uint64_t count);

/// Bytes of all values, before they are compressed.
uint64_t stp_store_values_bytes(uint32_t attributes, uint64_t count);

/// Whether a block of so many bytes can hold them.
bool stp_store_can_hold_values(uint32_t attributes, uint64_t count, uint64_t size);

/// Orders the bytes of a chunk's values. `out` has room for all.
void stp_store_split_values(const void* values, size_t count, size_t size, bool differences,
                            unsigned char* out);

typedef void (*stp_store_take_values)(void* user, uint64_t first, const void* values, size_t count);

/// Reads values [first, end) of an attribute that the block has, and hands them over in runs, in order. Any thread.
/// `read_bytes` is raised by the bytes read.
/// @return what of the block is wrong ("checksum"), stp_store_unreadable, or NULL
const char* stp_store_read_values(const stp_store_values* values, stp_attribute attribute,
                                  uint64_t first, uint64_t end, stp_store_take_values take,
                                  void* user, uint64_t* read_bytes);
