// SPDX-License-Identifier: MIT
#include "base/hash.h"

#include <xxhash.h>

stp_hash stp_hash_bytes(stp_hash chain, const void* bytes, size_t size)
{
    XXH128_hash_t hash = XXH3_128bits_withSeed(bytes, size, chain.low);
    // the seed carries 64 bits of the chain; the others are mixed in here
    uint64_t high = chain.high * UINT64_C(0x9E3779B97F4A7C15);
    return (stp_hash){.low = hash.low64, .high = hash.high64 ^ (high << 31 | high >> 33)};
}
