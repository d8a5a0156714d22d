// SPDX-License-Identifier: MIT
#include "tests.h"

#include "base/core/processor.h"
#include "base/io/hash.h"

#include <string.h>

void test_crc32c_known_values(test_state* test)
{
    // RFC 3720, appendix B.4
    unsigned char bytes[32];
    memset(bytes, 0, sizeof(bytes));
    CHECK_EQUAL(0x8a9136aa, stp_crc32c(bytes, sizeof(bytes)));
    memset(bytes, 255, sizeof(bytes));
    CHECK_EQUAL(0x62a8ab43, stp_crc32c(bytes, sizeof(bytes)));
    CHECK_EQUAL(0xe3069283, stp_crc32c("123456789", 9));
    CHECK_EQUAL(0, stp_crc32c("", 0));
}

void test_crc32c_variants_agree(test_state* test)
{
    unsigned char bytes[300];
    for (size_t i = 0; i < sizeof(bytes); ++i) {
        bytes[i] = (unsigned char)(i * i * 7 + 3);
    }
    CHECK_EQUAL(0xe3069283, stp_crc32c_portable("123456789", 9));
    if (stp_processor_detect() >= STP_PROCESSOR_VECTOR) {
        for (size_t begin = 0; begin < 9; ++begin) {
            for (size_t size = 0; size + begin <= sizeof(bytes); ++size) {
                CHECK_EQUAL(stp_crc32c_portable(bytes + begin, size),
                            STP_VECTOR(stp_crc32c)(bytes + begin, size));
            }
        }
    }
}
