// SPDX-License-Identifier: MIT
// stp_crc32c with the SSE4.2 instruction, eight bytes at a time.
#include "base/io/bytes.h"
#include "base/io/hash.h"

#include <nmmintrin.h>

uint32_t stp_crc32c_vector(const void* bytes, size_t size)
{
    const unsigned char* at = bytes;
    uint64_t crc = UINT32_MAX;
    for (; size >= 8; size -= 8, at += 8) {
        crc = _mm_crc32_u64(crc, stp_read_u64(at));
    }
    for (; size > 0; --size, ++at) {
        crc = _mm_crc32_u8((uint32_t)crc, *at);
    }
    return ~(uint32_t)crc;
}
