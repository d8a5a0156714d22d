// SPDX-License-Identifier: MIT
// Content identity: equal content has an equal hash on every machine (XXH3, 128 bits, by libxxhash).
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

typedef struct stp_hash {
    uint64_t low, high;
} stp_hash;

/// Hashes `size` bytes. `chain` (may be all zero) makes a hash of a sequence: pass the hash so far.
stp_hash stp_hash_bytes(stp_hash chain, const void* bytes, size_t size);

/// Bytes somewhere in memory.
typedef struct stp_bytes {
    const void* bytes;
    size_t size;
} stp_bytes;

/// A checksum (XXH3, 64 bits) of the pieces as if they lay one after the other.
uint64_t stp_checksum(const stp_bytes* pieces, size_t piece_count);

static inline bool stp_hash_equal(stp_hash a, stp_hash b)
{
    return a.low == b.low && a.high == b.high;
}
