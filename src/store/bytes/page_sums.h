// SPDX-License-Identifier: MIT
// Collects the page checksums of sections during writing.
#pragma once

#include "base/core/context.h"
#include "store/bytes/format.h"

typedef struct stp_store_page_sums {
    stp_context* context;
    uint32_t* crcs; ///< checksums of all pages so far, the last perhaps incomplete (stp_free)
    size_t count, capacity;
    size_t filled;                       ///< bytes in the last page
    bool open;                           ///< a section is being written
    size_t first_pages[STP_SECTION_END]; ///< first page of each section written
} stp_store_page_sums;

/// Begins a section; its bytes follow. The section of checksums itself and packed sections get
/// none.
void stp_store_page_sums_begin(stp_store_page_sums* sums, uint32_t type, bool packed);
/// Adds bytes of the open section; ignored for sections without checksums. @return STP_OK,
/// OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_store_page_sums_add(stp_store_page_sums* sums, const void* bytes,
                                                size_t size);
/// Replaces all bytes of a section by the same number of new ones.
void stp_store_page_sums_replace(stp_store_page_sums* sums, uint32_t type, const void* bytes,
                                 size_t size);
