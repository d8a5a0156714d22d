// SPDX-License-Identifier: MIT
// Checksums of the pages of sections, gathered while they are written.
#pragma once

#include "base/context.h"
#include "store/format.h"

typedef struct stp_store_page_sums {
    stp_context* context;
    uint32_t* crcs; ///< of all pages so far; the last one's may be growing (stp_free)
    size_t count, capacity;
    size_t filled;                       ///< bytes in the last page
    bool open;                           ///< a section is being written
    size_t first_pages[STP_SECTION_END]; ///< of each section written
} stp_store_page_sums;

/// A section begins. Its bytes follow; the section of checksums itself has none, nor have packed ones.
void stp_store_page_sums_begin(stp_store_page_sums* sums, uint32_t type, bool packed);
/// Bytes of the section that is open; of others nothing is kept. @return STP_OK, OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_page_sums_add(stp_store_page_sums* sums, const void* bytes,
                                                size_t size);
/// All bytes of a section anew, as many as before.
void stp_store_page_sums_replace(stp_store_page_sums* sums, uint32_t type, const void* bytes,
                                 size_t size);
