// SPDX-License-Identifier: MIT
// Content hashes and checksums, equal on every machine.
#pragma once

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Content hashes: XXH3, 128 bits, by libxxhash.

typedef struct stp_hash {
    uint64_t low, high;
} stp_hash;

/// Hashes `size` bytes. To hash a sequence, pass the hash so far as `chain` (all zero to begin).
stp_hash stp_hash_bytes(stp_hash chain, const void* bytes, size_t size);

/// The same hash, read in steps: `done` is called with each range once it is read.
stp_hash stp_hash_steps(stp_hash chain, const void* bytes, size_t size,
                        void (*done)(const void* bytes, size_t size));

/// A range of memory.
typedef struct stp_bytes {
    const void* bytes;
    size_t size;
} stp_bytes;

/// XXH3 checksum, 64 bits, of the concatenated parts.
uint64_t stp_checksum(const stp_bytes* parts, size_t part_count);

static inline bool stp_hash_equal(stp_hash a, stp_hash b)
{
    return a.low == b.low && a.high == b.high;
}

// CRC-32C (Castagnoli), the checksum of the pages of E57 files.

/// Checksum of `size` bytes: reflected, initial value and final XOR all ones. Any thread.
uint32_t stp_crc32c(const void* bytes, size_t size);

/// Variants, portable and with the CPU's CRC instruction; stp_crc32c chooses.
uint32_t stp_crc32c_portable(const void* bytes, size_t size);
uint32_t stp_crc32c_vector(const void* bytes, size_t size);
