// SPDX-License-Identifier: MIT
#define XXH_STATIC_LINKING_ONLY // allows the state to be a local variable
#include "base/io/hash.h"

#include <assert.h>
#include <xxhash.h>

#define STEP ((size_t)16 << 20)

static stp_hash mix(stp_hash chain, XXH128_hash_t hash)
{
    // the seed carries 64 bits of the chain; mix in the other 64
    uint64_t high = chain.high * UINT64_C(0x9E3779B97F4A7C15);
    return (stp_hash){.low = hash.low64, .high = hash.high64 ^ (high << 31 | high >> 33)};
}

stp_hash stp_hash_bytes(stp_hash chain, const void* bytes, size_t size)
{
    return mix(chain, XXH3_128bits_withSeed(bytes, size, chain.low));
}

stp_hash stp_hash_steps(stp_hash chain, const void* bytes, size_t size,
                        void (*done)(const void* bytes, size_t size))
{
    assert((bytes != NULL || size == 0) && done != NULL);
    const unsigned char* from = bytes;
    XXH3_state_t state;
    XXH3_INITSTATE(&state); // otherwise it keeps what memory holds if that looks like the same seed
    (void)XXH3_128bits_reset_withSeed(&state, chain.low);
    for (size_t at = 0, step; at < size; at += step) {
        step = size - at < STEP ? size - at : STEP;
        (void)XXH3_128bits_update(&state, from + at, step);
        done(from + at, step);
    }
    return mix(chain, XXH3_128bits_digest(&state));
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
