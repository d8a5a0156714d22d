// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_e57 -max_total_time=60 -max_len=4096 build/corpus/fuzz_e57
// Seeds: files of tests/import/e57_writer.h
//
// Arbitrary bytes as E57, with corrected page checksums: rejected with one sentence, or a valid
// scene.
#include "fuzz_import.h"

#include "import/e57_writer.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    unsigned char* bytes = malloc(size + 1);
    if (bytes == NULL) {
        return 0;
    }
    memcpy(bytes, data, size);
    if (size >= 48) { // smaller files are rejected at once
        memcpy(bytes, "ASTM-E57\1\0\0\0\0\0\0\0", 16);
        stp_write_u64(bytes + 16, size / 1024 * 1024);
        stp_write_u64(bytes + 40, 1024);
    }
    e57_seal(bytes, size);
    fuzz_import("input.e57", bytes, size);
    free(bytes);
    return 0;
}
