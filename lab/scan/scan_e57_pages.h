// SPDX-License-Identifier: MIT
// The pages that an E57 file (ASTM E2807) is made of: 1,020 bytes and their CRC-32C. Offsets within
// the file count the checksums (physical) or leave them out (logical).
#pragma once

#include "base/io/file.h"

enum { E57_PAGE = 1024, E57_PAYLOAD = 1020 };

/// Pages being written; the last, incomplete page is buffered here.
typedef struct e57_pages {
    stp_file_writer* writer;
    uint64_t whole; ///< pages written
    size_t used;    ///< buffered bytes of the next page, below E57_PAYLOAD
    unsigned char payload[E57_PAYLOAD];
} e57_pages;

/// Offset of the next byte.
uint64_t e57_physical(const e57_pages* pages);
uint64_t e57_logical(const e57_pages* pages);

STP_MUST_USE stp_result e57_put(e57_pages* pages, const void* bytes, size_t size);
/// Fills the page with zeros and writes it, unless it is empty.
STP_MUST_USE stp_result e57_end_page(e57_pages* pages);
/// Rewrites a whole page.
/// @param payload E57_PAYLOAD bytes
STP_MUST_USE stp_result e57_replace_page(e57_pages* pages, uint64_t page,
                                         const unsigned char* payload);
