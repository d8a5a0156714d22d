// SPDX-License-Identifier: MIT
//
// build/fuzz/fuzz/fuzz_hgt -max_total_time=60 -max_len=4096 build/corpus/fuzz_hgt
// Seeds: none are needed
//
// Any heights: the bytes repeated to a tile. Each makes a sound scene, whose mesh has the voids left out.
#include "fuzz_points.h"

int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size)
{
    enum { TILE = 2 * 1201 * 1201 };
    unsigned char* bytes = malloc(TILE);
    for (size_t i = 0; bytes != NULL && i < TILE; ++i) {
        bytes[i] = size > 0 ? data[i % size] : 0;
    }
    if (bytes != NULL) {
        fuzz_import("N48E010.hgt", bytes, TILE);
    }
    free(bytes);
    return 0;
}
