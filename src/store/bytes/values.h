// SPDX-License-Identifier: MIT
// An attribute block: chunks of values, their table, and its checksum.
//
//   chunks of the first attribute | chunks of the second | ... | table | checksum of the table
//
// The table has the size and checksum of each chunk.
//
// A chunk holds 64 KiB of values, split into byte planes: the lowest bytes of all values first.
// Values of point sets are stored as differences from the previous value.
#pragma once

#include "store/bytes/deflate.h"
#include "store/bytes/format.h"

#include <stipple/attributes.h>

enum { STP_STORE_VALUES_ENCODING = 0 };

/// The content and source of an attribute block.
typedef struct stp_store_values {
    const stp_store_block* block;
    uint32_t attributes; ///< bit mask
    uint64_t count;      ///< values per attribute
    bool (*read)(void* user, uint64_t offset, void* bytes, size_t size);
    void* user;
} stp_store_values;

/// Number of values per chunk.
static inline uint32_t stp_store_values_each(stp_attribute attribute)
{
    return (uint32_t)(STP_STORE_CHUNK_BYTES / stp_attribute_size(attribute));
}

static inline bool stp_store_has_bit(uint32_t attributes, uint32_t attribute)
{
    return (attributes >> attribute & 1) != 0;
}

/// Number of chunks for this many values per attribute.
uint64_t stp_store_values_chunks(uint32_t attributes, uint64_t count);

/// Whether a block of this size can hold them.
bool stp_store_can_hold_values(uint32_t attributes, uint64_t count, uint64_t size);

/// Splits the values of a chunk into byte planes. `out` has room for all.
void stp_store_split_values(const void* values, size_t count, size_t size, bool differences,
                            unsigned char* out);

typedef void (*stp_store_take_values)(void* user, uint64_t first, const void* values, size_t count);

/// Reads values [first, end) of an attribute in the block, and passes them on in runs, in order.
/// Adds the bytes read to `read_bytes`. Any thread.
/// @return NULL, or the error in the block ("checksum"), or stp_store_unreadable, or
/// stp_store_no_memory
const char* stp_store_read_values(const stp_store_values* values, stp_attribute attribute,
                                  uint64_t first, uint64_t end, stp_store_take_values take,
                                  void* user, uint64_t* read_bytes);
