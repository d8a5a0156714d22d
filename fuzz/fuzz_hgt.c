// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_hgt -max_total_time=60 -max_len=4096 build/corpus/fuzz_hgt
// Seeds: not needed
//
// Arbitrary heights at the northern end of a tile that is otherwise void: a valid scene whose mesh
// omits the voids.
#include "fuzz_import.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    enum { TILE = 2 * 1201 * 1201 };
    unsigned char* bytes = malloc(TILE);
    for (size_t i = 0; bytes != NULL && i < TILE; ++i) {
        bytes[i] = i % 2 == 0 ? 0x80 : 0;
    }
    if (bytes != NULL) {
        memcpy(bytes, data, size < TILE ? size : TILE);
        fuzz_import("N48E010.hgt", bytes, TILE);
    }
    free(bytes);
    return 0;
}
