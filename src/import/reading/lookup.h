// SPDX-License-Identifier: MIT
// A table from content (any bytes, identified by their 128-bit hash) to a number.
#pragma once

#include "base/core/context.h"
#include "base/io/hash.h"

typedef struct stp_lookup_entry {
    stp_hash hash;
    uint32_t value;
    uint32_t used;
} stp_lookup_entry;

/// All zero with a context is an empty table.
typedef struct stp_lookup {
    stp_context* context;
    stp_lookup_entry* entries;
    size_t count, size;
} stp_lookup;

/// Finds the value stored under `key`; if there is none, stores `fresh`. @return STP_OK, or
/// STP_ERROR_OUT_OF_MEMORY (logged)
STP_MUST_USE stp_result stp_lookup_add(stp_lookup* lookup, const void* key, size_t size,
                                       uint32_t fresh, uint32_t* value);
/// The value stored under `key`, or `missing`.
uint32_t stp_lookup_find(const stp_lookup* lookup, const void* key, size_t size, uint32_t missing);
void stp_lookup_destroy(stp_lookup* lookup);
