// SPDX-License-Identifier: MIT
#define XXH_STATIC_LINKING_ONLY // allows the state to be a local variable
#include "base/hash.h"

#include <xxhash.h>

stp_hash stp_hash_bytes(stp_hash chain, const void* bytes, size_t size)
{
    XXH128_hash_t hash = XXH3_128bits_withSeed(bytes, size, chain.low);
    // the seed carries 64 bits of the chain; mix in the other 64
    uint64_t high = chain.high * UINT64_C(0x9E3779B97F4A7C15);
    return (stp_hash){.low = hash.low64, .high = hash.high64 ^ (high << 31 | high >> 33)};
}

uint64_t stp_checksum(const stp_bytes* pieces, size_t piece_count)
{
    if (piece_count == 1) {
        return XXH3_64bits(pieces[0].bytes, pieces[0].size);
    }
    XXH3_state_t state;
    (void)XXH3_64bits_reset(&state);
    for (size_t i = 0; i < piece_count; ++i) {
        if (pieces[i].size != 0) {
            (void)XXH3_64bits_update(&state, pieces[i].bytes, pieces[i].size);
        }
    }
    return XXH3_64bits_digest(&state);
}
