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

static inline bool stp_hash_equal(stp_hash a, stp_hash b)
{
    return a.low == b.low && a.high == b.high;
}
