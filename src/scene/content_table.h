// SPDX-License-Identifier: MIT
// Maps content to the first index with that content.
#pragma once

#include "base/core/context.h"
#include "base/io/hash.h"

typedef struct stp_content_entry {
    stp_hash hash;
    uint32_t index; ///< UINT32_MAX: free
} stp_content_entry;

/// Initialise to zero: empty.
typedef struct stp_content_table {
    stp_content_entry* entries;
    size_t size, count; ///< size: a power of two, or 0
} stp_content_table;

/// Returns the first index stored for this content; stores `index` if it is new.
/// @return STP_OK or STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_content_table_find(stp_context* context, stp_content_table* table,
                                               stp_hash hash, uint32_t index, uint32_t* found);
void stp_content_table_destroy(stp_context* context, stp_content_table* table);
