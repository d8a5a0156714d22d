// SPDX-License-Identifier: MIT
// stp_crc32c with ARM's CRC instructions, which nearly every processor of 64 bits has, eight bytes
// at a time.
#include "base/io/bytes.h"
#include "base/io/hash.h"

#include <arm_acle.h>
#include <sys/auxv.h>

#define HAS_CRC32 (1UL << 7) // HWCAP_CRC32 of Linux

uint32_t stp_crc32c_vector(const void* bytes, size_t size)
{
    if ((getauxval(AT_HWCAP) & HAS_CRC32) == 0) {
        return stp_crc32c_portable(bytes, size);
    }
    const unsigned char* at = bytes;
    uint32_t crc = UINT32_MAX;
    for (; size >= 8; size -= 8, at += 8) {
        crc = __crc32cd(crc, stp_read_u64(at));
    }
    for (; size > 0; --size, ++at) {
        crc = __crc32cb(crc, *at);
    }
    return ~crc;
}
