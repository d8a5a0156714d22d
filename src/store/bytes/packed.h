// SPDX-License-Identifier: MIT
//
// Sections stored as separately compressed and checksummed pages (docs/format.md, Packed sections).
// Since version 1.2. A page holds as many whole records as fit in 64 KiB. A table of sizes and
// checksums precedes the pages.
#pragma once

#include "store/bytes/deflate.h"
#include "store/bytes/format.h"

#include <assert.h>

static inline bool stp_store_is_packed(const stp_store_section* section)
{
    return (section->flags & STP_SECTION_PACKED) != 0;
}

/// Decoded size of all records.
static inline uint64_t stp_store_content_bytes(const stp_store_section* section)
{
    return section->count * section->record_size;
}

/// Decoded size of every page but the last one.
static inline uint32_t stp_store_packed_page_bytes(const stp_store_section* section)
{
    assert(section->record_size != 0 && section->record_size <= STP_STORE_CHUNK_BYTES);
    return STP_STORE_CHUNK_BYTES / section->record_size * section->record_size;
}

static inline uint64_t stp_store_packed_page_count(const stp_store_section* section)
{
    uint32_t page = stp_store_packed_page_bytes(section);
    return (stp_store_content_bytes(section) + page - 1) / page;
}

static inline uint64_t stp_store_packed_table_bytes(const stp_store_section* section)
{
    return stp_store_packed_page_count(section) * STP_STORE_CHUNK_ENTRY;
}

/// Whether a packed section of this size can hold its records. `record_size` is not 0.
static inline bool stp_store_can_pack(const stp_store_section* section)
{
    if (section->record_size > STP_STORE_CHUNK_BYTES || section->count > UINT32_MAX) {
        return false;
    }
    uint64_t content = stp_store_content_bytes(section);
    uint64_t pages = stp_store_packed_page_count(section);
    uint64_t table = stp_store_packed_table_bytes(section);
    return section->size >= table && section->size - table <= content &&
           section->size - table + pages >= content / STP_STORE_CHUNK_RATIO;
}
